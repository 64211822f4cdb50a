"""What a measurement of a published figure computes with: simulators of scenes, which it keeps, and figures with their limits."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.numerics import Floats, Singles
from radar_service.radar import radar_sets
from radar_service.scene_file import load_scene
from radar_service.simulator import Simulator
from radar_service.terminal import write_file

Table = dict[str, Any]  # of a scene file
Measurement = Callable[["Run"], list["Figure"]]
NM = 1852.0  # m
# Ships' sets on the air, of the standard's ranges: on the shortest scale that shows all that is asked.
SETS: dict[str, Table] = {
    band: {"set": name, "height_m": 15, "loss_db": 9, "noise_figure_db": 5}
    for band, name in (("X", "furuno-far-2127"), ("S", "furuno-far-2137s"))
}
# Ships' sets with one pulse a spoke. X: 25 kW, 1 degree (Sperry Bridgemaster of 2.4 m, as the IfAOe has it). S: 30 kW, 12 ft,
# 1.9 degrees. Receiver and losses are those of the scenario msc192-table2.
X: Table = {
    "azimuths": 1024, "rpm": 24, "height_m": 15, "pattern": "taylor", "modulation": "none", "pulse_s": 2.5e-7,
    "beamwidth_deg": 1.0, "power_w": 25e3, "gain_dbi": 31, "loss_db": 9, "noise_figure_db": 5,
}  # fmt: skip
S = X | {"frequency_hz": 3.05e9, "beamwidth_deg": 1.9, "power_w": 30e3, "gain_dbi": 27}
SHORT = {"pulse_s": 7e-8}
BARE: Table = {"azimuths": 720, "height_m": 15, "pattern": "gaussian", "pattern_el": "gaussian", "beamwidth_deg": 1.0}


@dataclass(frozen=True)
class Figure:
    """One number of a row. what: of what; computed: ours; low, high: limits, infinite where there is none; unit."""

    what: str
    computed: float
    low: float
    high: float
    unit: str = ""

    @classmethod
    def near(cls, what: str, computed: float, published: float, share: float, unit: str = "") -> "Figure":
        """Returns a figure that may differ by a share of what was published."""
        return cls.within(what, computed, published, abs(published) * share, unit)

    @classmethod
    def within(cls, what: str, computed: float, published: float, half: float, unit: str = "") -> "Figure":
        """Returns a figure that may differ by `half` of its unit."""
        return cls(what, computed, published - half, published + half, unit)

    @classmethod
    def by_factor(cls, what: str, computed: float, low: float, high: float, factor: float, unit: str = "") -> "Figure":
        """Returns a figure that may lie by a factor beside a band."""
        return cls(what, computed, low / factor, high * factor, unit)

    @classmethod
    def least(cls, what: str, computed: float, low: float, unit: str = "") -> "Figure":
        """Returns a figure with a floor."""
        return cls(what, computed, low, math.inf, unit)

    @classmethod
    def most(cls, what: str, computed: float, high: float, unit: str = "") -> "Figure":
        """Returns a figure with a ceiling."""
        return cls(what, computed, -math.inf, high, unit)

    @property
    def inside(self) -> bool:
        """Whether it lies within its limits."""
        return self.low <= self.computed <= self.high

    @property
    def deviation(self) -> float:
        """Returns -1 at the lower limit and 1 at the upper one, more beyond them; of a single limit by halves of it."""
        if math.isinf(self.low):
            return max(1.0 + (self.computed - self.high) / max(0.5 * abs(self.high), 1e-9), -1.0)
        if math.isinf(self.high):
            return min((self.computed - self.low) / max(0.5 * abs(self.low), 1e-9) - 1.0, 1.0)
        return (2.0 * self.computed - self.low - self.high) / max(self.high - self.low, 1e-12)


class NotExpressed(Exception):
    """A row that the engine cannot express; the text says why."""


class Run:
    """Makes the simulators of one row, and keeps their scenes as files. folder: for them and the height maps that they need."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.count = folder, 0

    def simulator(
        self, radar: Table, environment: Table | None = None, bodies: Sequence[Table] = (), own_ship: Table | None = None,
        seed: int = 0, fidelity: str = "balanced", sector: tuple[float, float] | None = None,
        labels: bool = False,
    ) -> Simulator:  # fmt: skip
        """Returns a simulator of a scene of these tables. Raises SceneError."""
        bodies = [{"name": f"body {number}", **body} for number, body in enumerate(bodies)]
        tables = {"radar": radar, "environment": environment or {}, "own_ship": own_ship or {}, "body": bodies}
        self.count += 1
        path = self.folder / f"scene-{self.count}.json"
        write_file(path, json.dumps({"name": f"{self.folder.name}, scene {self.count}", **tables}, indent=1))
        return Simulator(load_scene(path), fidelity, seed, sector=sector, labels=labels)

    def height_map(self, name: str, heights: Floats) -> str:
        """Writes a height map (north to south, west to east) [m]; returns the name by which a body of a scene has it."""
        np.save(self.folder / f"{name}.npy", heights)
        return f"{name}.npy"


def reaching(radar: Table, reach: float) -> Table:
    """Returns a radar that shows so far [m]: a set on the shortest scale that does."""
    scales = radar_sets()[radar["set"]].scales if "set" in radar else (reach,)
    return radar | {"range_max_m": next(scale for scale in scales if scale >= reach)}


def placed(bearing: float, ground: float, height: float) -> list[float]:
    """Returns `position_m` at a bearing [rad], a distance along the map [m] and a height [m]."""
    return [ground * math.sin(bearing), ground * math.cos(bearing), height]


def ring(count: int) -> Floats:
    """Returns bearings (count,) [rad] evenly round, in the middle of spokes of 720 or 1024 a scan as far as they divide."""
    return np.asarray(2.0 * np.pi * np.arange(count) / count)


def around(
    power: Floats | Singles, simulator: Simulator, bearing: float, slant: float, cells: int = 1, beams: float = 0.5
) -> Floats:
    """Returns the part of a scan (A, N) within so many beamwidths and cells about a bearing [rad] and a slant range [m]."""
    radar = simulator.scene.radar
    half = max(0, int(beams * radar.beamwidth / radar.azimuth_step))
    spokes = (round(bearing / radar.azimuth_step) + np.arange(-half, half + 1)) % radar.azimuths
    middle = int(slant / simulator.range_step)
    return np.asarray(power[spokes, max(middle - cells, 0) : middle + cells + 1], dtype=np.float64)


def db(ratio: float) -> float:
    """Returns a power ratio in decibels."""
    return 10.0 * math.log10(max(ratio, 1e-30))


def sections(run: Run, radar: Table, environment: Table, bodies: Sequence[Table], own_ship: Table | None = None) -> Floats:
    """Returns the effective cross-sections (B,) [dBsm] of bodies as the beam crosses them in the first scan, -100 for none."""
    simulator = run.simulator(radar, environment, bodies, own_ship)
    dbsm = np.full(len(bodies), -100.0)
    for crossing in simulator.crossings(0, radiometric=True):
        if crossing.rcs_dbsm is not None:
            dbsm[int(crossing.body.split()[-1])] = crossing.rcs_dbsm
    return dbsm
