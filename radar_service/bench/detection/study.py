"""Detection by range, measured on simulated scans and compared with the radar equation.

Every target of a scenario stands at many ranges at once, each on a spoke and in the middle of a range cell, so that no power is
lost between spokes or cells. A scan detects a target where its cell exceeds the threshold on any spoke of the half-power beam.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from radar_service.batch.jobs import Executor, Job, Progress, run
from radar_service.bench.detection.detection import (
    CRITERION,
    PFA,
    Target,
    eight_of_ten,
    ground_distance,
    predicted_curve,
    signal_to_noise,
    spoke_gains,
)  # fmt: skip
from radar_service.bench.detection.verdicts import HIGHEST, LOWEST, Measured, judged
from radar_service.bench.scenario import CLUTTER, Scenario, ScenarioError
from radar_service.numerics.gamma_law import known_level_factor
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.receive.compression import receiver_noise_power
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from radar_service.world.scene import Scene

SCHEMA = 1
MARGIN = 0.03  # Pd to which ranges are spread beyond these
SCANS_PER_JOB = 50


@dataclass(frozen=True)
class TargetCells:
    """Where the bodies of a study stand. target: index (B,); cell, spoke: of each (B,); predicted: SNR (B,), a power ratio."""

    target: Indices
    cell: Indices
    spoke: Indices
    predicted: Floats


@dataclass(frozen=True)
class BodyCounts:
    """What scans gave for each body (B,). scans: number; hits: detections; snr, square: sums of the SNR and of its square."""

    scans: int
    hits: Indices
    snr: Floats
    square: Floats

    def plus(self, other: "BodyCounts") -> "BodyCounts":
        """Both together."""
        return BodyCounts(self.scans + other.scans, self.hits + other.hits, self.snr + other.snr, self.square + other.square)


def detection_study(
    scenario: Scenario,
    scans: int,
    ranges: int,
    executor: Executor | None = None,
    progress: Progress = lambda parts, count: parts,
    seed: int = 0,
) -> dict[str, Any]:
    """Returns the study of a scenario as plain data: in free space, and over the sea where the scenario has multipath.

    scans: of each range; ranges: of each target; executor, progress: as `batch.jobs.run`; seed: of
    the first part, each of SCANS_PER_JOB scans; the next ones have the next seeds.
    Raises ScenarioError for targets or an environment that the radar equation does not cover, SceneError, and JobsFailed.
    """
    targets = targets_of(scenario)
    kinds = [False, True] if scenario.scene.get("environment", {}).get("multipath") else [False]
    shares = [min(SCANS_PER_JOB, scans - first) for first in range(0, scans, SCANS_PER_JOB)]
    parts = [
        Job(f"{scenario.name}, {_sea(multipath)}, seed {seed + k}", (scenario, multipath, ranges, seed + k, share))
        for multipath in kinds
        for k, share in enumerate(shares)
    ]
    counted = run(count, parts, executor, progress=progress)
    series = []
    for number, multipath in enumerate(kinds):
        every = reduce(BodyCounts.plus, counted[number * len(shares) : (number + 1) * len(shares)])
        series.append(_series(study_scene(scenario, multipath, ranges), targets, every, multipath))
    return {
        "schema": SCHEMA, "scenario": scenario.name, "question": scenario.question, "source": scenario.source, "scans": scans,
        "pfa": PFA, "criterion": CRITERION, "eight_of_ten": float(eight_of_ten(np.array(CRITERION))), "series": series,
    }  # fmt: skip


def targets_of(scenario: Scenario) -> list[Target]:
    """Returns the targets of a scenario. Raises ScenarioError for one that is no point of a declared cross-section."""
    bodies = [body for body in scenario.scene.get("body", ()) if body["name"] in scenario.tracked]
    for body in bodies:
        if body.get("shape") != "point" or "rcs_dbsm" not in body:
            raise ScenarioError(
                f'{scenario.name}: body "{body["name"]}": detection is judged for points with rcs_dbsm; leave it out of targets'
            )
    air = scenario.scene.get("environment", {})
    if not air.get("noise") or any(map(air.get, CLUTTER)):
        raise ScenarioError(
            f"{scenario.name}: environment: detection is judged in noise alone; give noise = true, no sea, no rain"
        )
    return [Target.of(scenario, body) for body in bodies]


def study_scene(scenario: Scenario, multipath: bool, ranges: int) -> tuple[Scene, TargetCells]:
    """Returns the scene of a study and where its bodies stand. Raises ScenarioError where no target is anywhere in doubt."""
    targets = targets_of(scenario)
    air = {**scenario.scene["environment"], "multipath": multipath}
    bare = load_scene({**scenario.scene, "own_ship": {}, "environment": air, "body": []})
    rows = [(number, cell) for number, target in enumerate(targets) for cell in cells_of(bare, target, ranges)]
    if not rows:
        raise ScenarioError(
            f"{scenario.name}: no range has a Pd between {LOWEST} and {HIGHEST}; change range_max_m or power_w"
        )
    spokes = np.rint(np.arange(len(rows)) * bare.radar.azimuths / len(rows)).astype(np.int64)
    slant = np.array([(cell + 0.5) * bare.radar.range_step for _, cell in rows])
    bodies, predicted = [], []
    for (number, cell), spoke, distance in zip(rows, spokes.tolist(), slant, strict=True):
        target, angle = targets[number], spoke * bare.radar.azimuth_step
        ground = ground_distance(np.array([distance]), target.height, bare.radar, bare.environment)
        position = [float(ground[0] * np.sin(angle)), float(ground[0] * np.cos(angle)), target.height]
        bodies.append({
            "name": f"{target.name} {cell}", "shape": "point", "rcs_dbsm": target.rcs_dbsm, "swerling": target.swerling,
            "position_m": position,
        })  # fmt: skip
        predicted.append(float(signal_to_noise(bare.radar, bare.environment, ground, target)[0]))
    scene = load_scene({**scenario.scene, "name": scenario.name, "own_ship": {}, "environment": air, "body": bodies})
    cells = TargetCells(np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), spokes, np.array(predicted))
    return scene, cells


def cells_of(scene: Scene, target: Target, ranges: int) -> list[int]:
    """Returns the range cells at which a target is measured, evenly among those where Pd is uncertain."""
    distance, pd = predicted_curve(scene.radar, scene.environment, target)
    uncertain = distance[(pd > LOWEST - MARGIN) & (pd < HIGHEST + MARGIN)]
    if not len(uncertain):
        return []
    chosen = uncertain[np.linspace(0, len(uncertain) - 1, ranges).astype(np.int64)]
    cells: list[int] = np.unique((chosen / scene.radar.range_step).astype(np.int64)).tolist()
    return cells


def count(scenario: Scenario, multipath: bool, ranges: int, seed: int, scans: int) -> BodyCounts:
    """Returns what some scans of a study give. Raises as `study_scene`."""
    scene, cells = study_scene(scenario, multipath, ranges)
    simulator, noise = Simulator(scene, scenario.fidelity, seed), receiver_noise_power(scene.radar)
    half = len(spoke_gains(scene.radar)) // 2
    beam = (cells.spoke[:, None] + np.arange(-half, half + 1)) % scene.radar.azimuths
    power = np.stack([simulator.scan().power[beam, cells.cell[:, None]] for _ in range(scans)]).astype(np.float64) / noise
    snr = power[:, :, half] - 1.0
    factor = known_level_factor(PFA, scene.radar.pulses_integrated)
    return BodyCounts(scans, (power.max(axis=2) > factor).sum(axis=0), snr.sum(axis=0), (snr**2).sum(axis=0))


def _sea(multipath: bool) -> str:
    return "over the sea" if multipath else "free space"


def _series(
    study: tuple[Scene, TargetCells], targets: Sequence[Target], counts: BodyCounts, multipath: bool
) -> dict[str, Any]:
    scene, cells = study
    return {
        "environment": _sea(multipath),
        "targets": [_judged(scene, cells, counts, target, cells.target == number) for number, target in enumerate(targets)],
    }


def _judged(scene: Scene, cells: TargetCells, counts: BodyCounts, target: Target, own: Flags) -> dict[str, Any]:
    """One target of a series. own: which bodies (B,) are hers."""
    measured = Measured(
        np.asarray((cells.cell[own] + 0.5) * scene.radar.range_step, dtype=np.float64), cells.predicted[own], counts.scans,
        counts.hits[own], counts.snr[own], counts.square[own],
    )  # fmt: skip
    return judged(scene.radar, scene.environment, target, measured)
