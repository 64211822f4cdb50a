"""Detection by range, measured on simulated scans and compared with the radar equation.

Every target stands at many ranges at once, on a spoke and in the middle of a range cell, so that no power is lost between them. A
scan detects a target where its cell exceeds the threshold on any spoke of the half-power beam.
"""

from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from scipy.stats import binom, binomtest

from radar_service.batch.jobs import Executor, Job, Progress, run
from radar_service.bench.detection.detection import (
    CRITERION,
    PFA,
    ScanDetection,
    Target,
    eight_of_ten,
    ground_distance,
    predicted_curve,
    signal_to_noise,
    spoke_gains,
)  # fmt: skip
from radar_service.bench.scenario import CLUTTER, Scenario, ScenarioError
from radar_service.numerics import NAUTICAL_MILE, Floats, Indices, known_level_factor
from radar_service.receive import receiver_noise_power
from radar_service.scene_file import load_scene
from radar_service.simulator import Simulator
from radar_service.world import Scene

SCHEMA = 1
LOWEST, HIGHEST = 0.05, 0.95  # Pd of the ranges that are tested
MARGIN = 0.03  # Pd to which ranges are spread beyond these
SCANS_PER_JOB = 50
SIGNIFICANCE = 0.001
SNR_LIMIT_DB = 0.5
SURE = 3.0  # standard errors
CURVE = 500  # points of a curve in a report, or up to twice as many
ENVIRONMENTS = {False: "free space", True: "over the sea"}  # by multipath


@dataclass(frozen=True)
class TargetCells:
    """Where the bodies of a study stand. target: index (B,); cell, spoke: of each (B,); predicted: SNR (B,), a power ratio."""

    target: Indices
    cell: Indices
    spoke: Indices
    predicted: Floats


def detection_study(
    scenario: Scenario, scans: int, ranges: int, executor: Executor | None = None,
    progress: Progress = lambda parts, count: parts, seed: int = 0,
) -> dict[str, Any]:  # fmt: skip
    """Returns the study of a scenario as plain data: in free space, and over the sea where the scenario has multipath.

    scans: of each range; ranges: of each target; executor, progress: as `batch.jobs.run`; seed: of the first SCANS_PER_JOB
    scans; the next ones have the next seeds. Raises ScenarioError, SceneError, and JobsFailed.
    """
    targets = targets_of(scenario)
    kinds = [False, True] if scenario.scene.get("environment", {}).get("multipath") else [False]
    shares = [min(SCANS_PER_JOB, scans - first) for first in range(0, scans, SCANS_PER_JOB)]
    parts = [
        Job(f"{scenario.name}, {ENVIRONMENTS[multipath]}, seed {seed + k}", (scenario, multipath, ranges, seed + k, share))
        for multipath in kinds
        for k, share in enumerate(shares)
    ]
    counted = iter(run(count, parts, executor, progress=progress))
    series = []
    for multipath in kinds:
        counts = sum(next(counted) for _ in shares)
        scene, cells = study_scene(scenario, multipath, ranges)
        judged_targets = []
        for number, target in enumerate(targets):
            of_target = cells.target == number
            distance = (cells.cell[of_target] + 0.5) * scene.radar.range_step
            judged_targets.append(judged(scene, target, scans, distance, cells.predicted[of_target], counts[:, of_target]))
        series.append({"environment": ENVIRONMENTS[multipath], "targets": judged_targets})
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
    bodies, predicted = [], []
    for (number, cell), spoke in zip(rows, spokes.tolist(), strict=True):
        target, angle = targets[number], spoke * bare.radar.azimuth_step
        slant = np.array([(cell + 0.5) * bare.radar.range_step])
        ground = ground_distance(slant, target.height, bare.radar, bare.environment)
        position = [float(ground[0] * np.sin(angle)), float(ground[0] * np.cos(angle)), target.height]
        bodies.append({
            "name": f"{target.name} {cell}", "shape": "point", "rcs_dbsm": target.rcs_dbsm, "swerling": target.swerling,
            "position_m": position,
        })  # fmt: skip
        predicted.append(float(signal_to_noise(bare.radar, bare.environment, ground, target)[0]))
    scene = load_scene({**scenario.scene, "name": scenario.name, "own_ship": {}, "environment": air, "body": bodies})
    target_of, cell_of = np.array(rows).T
    return scene, TargetCells(target_of, cell_of, spokes, np.array(predicted))


def cells_of(scene: Scene, target: Target, ranges: int) -> list[int]:
    """Returns the range cells at which a target is measured, evenly among those where Pd is uncertain."""
    distance, pd = predicted_curve(scene.radar, scene.environment, target)
    uncertain = distance[(pd > LOWEST - MARGIN) & (pd < HIGHEST + MARGIN)]
    if not len(uncertain):
        return []
    chosen = uncertain[np.linspace(0, len(uncertain) - 1, ranges).astype(np.int64)]
    cells: list[int] = np.unique((chosen / scene.radar.range_step).astype(np.int64)).tolist()
    return cells


def count(scenario: Scenario, multipath: bool, ranges: int, seed: int, scans: int) -> Floats:
    """Returns what some scans of a study give for each body (3, B): detections, sums of the SNR and of its square. Raises as
    `study_scene`."""
    scene, cells = study_scene(scenario, multipath, ranges)
    simulator, noise = Simulator(scene, scenario.fidelity, seed), receiver_noise_power(scene.radar)
    half = len(spoke_gains(scene.radar)) // 2
    beam = (cells.spoke[:, None] + np.arange(-half, half + 1)) % scene.radar.azimuths
    power = np.stack([simulator.scan().power[beam, cells.cell[:, None]] for _ in range(scans)]).astype(np.float64) / noise
    snr = power[:, :, half] - 1.0
    factor = known_level_factor(PFA, scene.radar.pulses_integrated)
    return np.stack([(power.max(axis=2) > factor).sum(axis=0), snr.sum(axis=0), (snr**2).sum(axis=0)])


def judged(scene: Scene, target: Target, scans: int, distance: Floats, predicted: Floats, counts: Floats) -> dict[str, Any]:
    """Returns the verdict on a target as plain data: by exact binomial tests and the mean SNR, with first-lost and last-held
    ranges. distance: rising slant ranges (R,) [m]; predicted: SNR (R,), a power ratio; counts: (3, R), as of `count`."""
    hits, snr, square = counts
    pd = ScanDetection(spoke_gains(scene.radar), target.swerling, PFA, scene.radar.pulses_integrated).of(predicted)
    tested = (pd > LOWEST) & (pd < HIGHEST)
    p = binomial_p(hits[tested], scans, pd[tested])
    difference, error = snr_difference_db(snr[tested], square[tested], scans, predicted[tested])
    curve_distance, curve = predicted_curve(scene.radar, scene.environment, target)
    every, share = max(1, len(curve) // CURVE), hits / scans
    lost, held = zip(lost_and_held(curve_distance, curve), lost_and_held(distance, share), strict=True)
    rows = {
        "range_m": distance, "predicted": pd, "detected": share, "eight_of_ten": eight_of_ten(pd),
        "snr_db": 10.0 * np.log10(predicted), "tested": tested,
    }  # fmt: skip
    return {
        "target": target.name, "rcs_dbsm": target.rcs_dbsm, "swerling": target.swerling, "height_m": target.height,
        "standard_nm": target.standard_nm, "p": p, "snr_difference_db": difference, "snr_error_db": error,
        "word": word(p, difference, error),
        "first_lost_m": dict(zip(("predicted", "measured"), lost, strict=True)),
        "last_held_m": dict(zip(("predicted", "measured"), held, strict=True)),
        "curve": {
            "range_nm": np.round(curve_distance[::every] / NAUTICAL_MILE, 4).tolist(),
            "predicted": np.round(curve[::every], 4).tolist(),
        },
        "ranges": [dict(zip(rows, row, strict=True)) for row in zip(*(column.tolist() for column in rows.values()), strict=True)],
    }  # fmt: skip


def binomial_p(hits: Floats, scans: int, pd: Floats) -> float | None:
    """Returns how likely hits (R,) of `scans` each are, or less likely ones, if detections have probabilities pd (R,).

    Two exact tests share the level: of the sum of all hits, which sees a shift, and of each range (Bonferroni), which sees a
    single one. None without ranges.
    """
    if not len(hits):
        return None
    single = min(float(binomtest(int(k), scans, float(p)).pvalue) for k, p in zip(hits, pd, strict=True))
    law = reduce(np.convolve, (binom.pmf(np.arange(scans + 1), scans, p) for p in pd))
    together = float(law[law <= law[int(hits.sum())] * (1.0 + 1e-7)].sum())
    return min(1.0, 2.0 * together, 2.0 * len(hits) * single)


def snr_difference_db(snr: Floats, square: Floats, scans: int, predicted: Floats) -> tuple[float | None, float | None]:
    """Returns the mean ratio of the measured SNR to the predicted one (R,), and its standard error [dB]; None without ranges.

    snr, square: sums (R,) over the scans of the SNR and of its square.
    """
    mean = snr / scans
    error = np.sqrt(np.maximum(square / scans - mean**2, 0.0) / scans) / predicted
    ratio = mean / predicted
    if not len(ratio) or not ratio.mean() > 0.0:
        return None, None
    slope = 10.0 / np.log(10.0) / ratio.mean()
    return float(10.0 * np.log10(ratio.mean())), float(slope * np.sqrt((error**2).sum()) / len(error))


def word(p: float | None, difference: float | None, error: float | None) -> str:
    """Returns the verdict on a target."""
    if p is None or difference is None or error is None:
        return "no range to test"
    if p <= SIGNIFICANCE or abs(difference) - SURE * error > SNR_LIMIT_DB:
        return "fail"
    return "pass" if abs(difference) <= SNR_LIMIT_DB else "undecided, more scans"


def lost_and_held(distance: Floats, pd: Floats) -> tuple[float | None, float | None]:
    """Returns the nearest of ranges (R,) whose Pd (R,) is below the criterion, and the farthest one whose Pd meets it; None
    where there is none."""
    lost, held = distance[pd < CRITERION], distance[pd >= CRITERION]
    return float(lost[0]) if len(lost) else None, float(held[-1]) if len(held) else None
