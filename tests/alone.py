"""Each source of a scene by itself: the engine runs with all other bodies silent, and without noise and the other effects.

Bodies stay in place, so shadows do too; so do rain and sea, which attenuate and reflect what bodies return.
"""

from collections.abc import Collection
from dataclasses import replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import Prepared, prepare
from radar_service.receive.compression import receiver_noise_power
from radar_service.records.fidelity import PRESETS
from radar_service.sources.numbers import BODY, FAINT, NOISE, SECOND_TIME_AROUND, source_numbers
from radar_service.stages.clutter.clutter import Clutter
from radar_service.stages.clutter.effect import RAIN, SEA
from radar_service.stages.clutter.stage import ClutterStage
from tests.scenes import point, scene

Fields = NDArray[np.complexfloating[Any, Any]]
Powers = dict[int, NDArray[np.float64]]
ROUNDING = 1e-14  # of the peak of a profile: the square of the relative precision of a float32, 6e-8, is 4e-15


@cache
def crowded(moves: bool, **environment: Any) -> rs.Scene:
    """Land, metal, wood, points that fluctuate, one in the blind sector, two beyond the unambiguous range, all effects on."""
    quay = {"name": "quay", "shape": "box", "length_m": 20, "width_m": 300, "height_m": 8, "position_m": [0, 500, 0]}
    ship = {"name": "ship", "shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6, "position_m": [0, 350, 0]}
    far = {"name": "far rock", "shape": "box", "length_m": 20, "width_m": 300, "height_m": 30, "position_m": [-900, 1200, 0]}
    corner = {"name": "corner", "shape": "trihedral", "edge_m": 0.5, "position_m": [300, 200, 5], "heading_deg": 240}
    bodies = [
        {**quay, "material": "concrete"}, {**ship, "material": "wood", "speed_kn": 12, "course_deg": 70},
        {**corner, "scattering": "optics"}, {**far, "material": "rock"}, point("steady", 400, -500),
        point("slow", -300, 50, rcs_dbsm=20, swerling=1), point("fast", 300, -60, swerling=4),
        point("blind", 40, -500, speed_kn=0.5), point("far point", 1300, 100, 30, rcs_dbsm=60, speed_kn=0.5),
        point("blind under way", -211, -453),
    ]  # fmt: skip
    return scene(
        bodies,
        radar={
            "range_max_m": 800, "azimuths": 72, "beamwidth_deg": 8, "pulse_s": 1e-6, "power_w": 0.05, "prf_hz": 150e3,
            "second_time_around": True, "blind_sectors_deg": [[170, 180]],
        },
        environment={"noise": True, "multipath": True, "sea_state": 2, "rain_mm_h": 0.5} | environment,
        interference=[{"bearing_deg": 250, "level_db": 60, "prf_hz": 40e3, "beamwidth_deg": 60}],
        own_ship={"speed_kn": 8, "course_deg": 30, "roll_deg": 4} if moves else {},
    )  # fmt: skip


class Alone:
    """Runs sources of a scene one by one. Each is prepared once for all scans; fields (A, N) [sqrt(W)]."""

    def __init__(self, made: rs.Scene, seed: int = 0) -> None:
        self._made, self._seed, self._every = made, seed, frozenset(range(len(made.bodies)))
        self._engines: dict[tuple[frozenset[int], bool], Engine] = {}
        self._fields: dict[tuple[frozenset[int], bool, int], Fields] = {}
        self._powers: dict[int, Powers] = {}

    def bodies(self, bodies: Collection[int], scan: int, earlier: bool = False) -> Fields:
        """Some bodies in one scan, with echoes of earlier pulses or without."""
        key = frozenset(bodies), earlier and self._made.radar.second_time_around
        if key not in self._engines:
            self._engines[key] = Engine(self._prepared(*key))
        if (*key, scan) not in self._fields:
            self._fields[*key, scan] = field_of(self._engines[key], scan)
        return self._fields[*key, scan]

    def others(self, scan: int) -> dict[int, Fields]:
        """All sources but bodies and noise. Echoes of earlier pulses are the difference that they make to each body alone."""
        fields = {SECOND_TIME_AROUND: sum((self._earlier(k, scan) for k in self._far(scan)), self.bodies([], scan))}
        full, nothing = self._full, self._prepared(frozenset(), False)
        stages, clutter = dict(full.stages), clutter_of(full)
        stage = stages.pop("clutter", None)
        if isinstance(stage, ClutterStage) and clutter is not None:
            sea, rain = replace(clutter, rain=np.zeros(0, dtype=np.float32)), replace(clutter, sea=None)
            for number, part in ((SEA, sea), (RAIN, rain)):
                alone = {"clutter": ClutterStage(stage.context, part)}
                fields[number] = field_of(Engine(replace(nothing, stages=alone)), scan)
        fields[3] = field_of(Engine(replace(nothing, stages=stages)), scan)
        return fields

    def powers(self, scan: int) -> Powers:
        """The power (A, N) [W] of each source in one scan, by source number."""
        if scan not in self._powers:
            self._powers[scan] = self._computed_powers(scan)
        return self._powers[scan]

    def _computed_powers(self, scan: int) -> Powers:
        numbers = source_numbers(self._made)[:-1]
        fields = {n: self.bodies(np.flatnonzero(numbers == n).tolist(), scan) for n in np.unique(numbers).tolist()}
        noise = receiver_noise_power(self._made.radar) if self._made.environment.noise else 0.0
        shape = self._made.radar.azimuths, self._made.radar.bins
        return {NOISE: np.full(shape, noise)} | {n: power_of(field) for n, field in (fields | self.others(scan)).items()}

    def _earlier(self, body: int, scan: int) -> Fields:
        return self.bodies([body], scan, earlier=True) - self.bodies([body], scan)

    def _far(self, scan: int) -> list[int]:
        """The bodies beyond half of the unambiguous range: all that may have echoes of earlier pulses."""
        _, time = self._made.radar.schedule(np.array([scan * self._made.radar.azimuths]))
        bodies = enumerate(self._made.bodies)
        offset = {k: body.motion.pose(time).position - self._made.antenna(time) for k, body in bodies}
        return [k for k, each in offset.items() if np.linalg.norm(each) > self._made.radar.unambiguous_range / 2.0]

    @cached_property
    def _full(self) -> Prepared:
        """With clutter and interference, without echoes of bodies."""
        return prepare(self._made, PRESETS["balanced"], self._seed, self._every)

    def _prepared(self, bodies: frozenset[int], earlier: bool) -> Prepared:
        """The engine without noise, clutter, interference and the echoes of other bodies."""
        made = self._made.with_world(environment=replace(self._made.environment, noise=False))
        made = replace(made, radar=replace(made.radar, second_time_around=earlier))
        return replace(prepare(made, PRESETS["balanced"], self._seed, self._every - bodies), stages={})


def clutter_of(prepared: Prepared) -> Clutter | None:
    """The clutter of a prepared scene; None without any."""
    stage = prepared.stages.get("clutter")
    return stage.clutter if isinstance(stage, ClutterStage) else None


@cache
def crowded_alone(moves: bool, **environment: Any) -> Alone:
    """The sources of a crowded scene one by one, kept for all tests of this process."""
    return Alone(crowded(moves, **environment))


def field_of(engine: Engine, scan: int) -> Fields:
    """The field (A, N) of one scan."""
    return np.concatenate([field for _, field, _ in engine.tiles(scan)])


def power_of(field: Fields) -> NDArray[np.float64]:
    """Its power [W]."""
    return np.abs(field.astype(np.complex128)) ** 2


def agreement(labels: NDArray[np.uint32], powers: Powers, within_db: float = 30.0) -> tuple[float, float]:
    """The share of cells whose label is the strongest source, of those where it leads by 3 dB; and how many these are of all.

    A body that is more than `within_db` below its own peak in the spoke counts as faint. Without noise there are cells in which
    the strongest source has but the rounding of its transforms: they do not count.
    """
    numbers, stacked = np.array(list(powers)), np.stack(list(powers.values()))
    strongest = stacked.argmax(axis=0)
    ordered = np.sort(stacked, axis=0)
    peak = stacked.max(axis=2)[strongest, np.arange(len(labels))[:, None]]  # of the same source in the same azimuth
    leads = (ordered[-1] > 10.0**0.3 * ordered[-2]) & (ordered[-1] > ROUNDING * peak)
    faint = (numbers[strongest] >= BODY) & (ordered[-1] < 10.0 ** (-within_db / 10.0) * peak)
    return float(np.mean(labels[leads] == np.where(faint, FAINT, numbers[strongest])[leads])), float(leads.mean())
