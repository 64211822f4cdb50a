"""Echoes of ships beside published bands: a table by ship, and polar plots.

    .venv/bin/python -m tests.measurements.ship_bands FOLDER [NAME ...] [--mesh NAME=FILE ...]

Each ship turns through all aspects 2 km from an antenna 15 m high: in free space, over a flat sea, and moved by the seaway of sea
states 1, 3 and 5. Aspects lie in windows of 5 degrees, 15 degrees apart; at sea state 3 more lie within 2 degrees of broadside,
and windows of bow and quarter have others, closer together, for the spread of single looks. Of many equal scatterers that is
5.57 dB (pi / sqrt 6 x 10 / ln 10, exponential power), of means of two looks 3.5 dB.
Without names all built-in ships, meshes of `scenes/` and those of `--mesh` (bow along y, waterline at 0) are measured. All are
dented (`plating`). FOLDER keeps what is measured, for another table, and polar plots.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

import radar_service as rs
from radar_service.numerics.types import Floats
from tests.measurements.cross_sections import sections_dbsm

SCENES = Path(__file__).parents[2] / "scenes"
DISTANCE, ANTENNA = 2000.0, 15.0  # m
WINDOW, STEP = 5.0, 15.0  # degrees: width and distance of windows
AWAY, BROADSIDE = 12.0, 2.0  # degrees off broadside: more is bow or quarter, less is broadside
PER_WINDOW, LOOKS = 2, 8  # aspects, and those for the spread: 22 windows then have 154 degrees of freedom, 6 % of the spread
FLOOR = -10.0  # dBsm of the middle of plots
TURN = 0.1  # degrees/s: an aspect is a time
SEAS: dict[str, dict[str, Any]] = {
    "free": {},
    "flat": {"multipath": True},
    **{str(state): {"multipath": True, "sea_state": state, "seaway": True} for state in (1, 3, 5)},
}
WAVES = ("1", "3", "5")  # the seas over which ships are compared with the bands, all together
UNDER_WAY, ABEAM = "3", 12  # the sea of broadsides and of the spread within windows, and aspects about each broadside there
# Medians over bow and quarter [dBsm], by the length of a ship [m]: Williams, Cramp and Curtis 1978 (X band, a coast station), as
# recalled; the document was not found.
BANDS = {(7.0, 12.0): (5.0, 10.0), (48.0, 58.0): (20.0, 36.0), (65.0, 80.0): (30.0, 44.0), (95.0, 110.0): (37.0, 50.0),
         (112.0, 170.0): (35.0, 52.0)}  # fmt: skip
SHIPS: dict[str, dict[str, Any]] = {
    "fishing, 9 m": {"shape": "hull", "hull_type": "fishing", "length_m": 9, "beam_m": 3.2, "height_m": 3.2},
    "pilot, 9 m": {"shape": "hull", "hull_type": "pilot", "length_m": 9, "beam_m": 3, "height_m": 3},
    "yacht, 9 m": {"shape": "hull", "hull_type": "yacht", "length_m": 9, "beam_m": 3, "height_m": 2.2},
    "fishing, 52 m": {"shape": "hull", "hull_type": "fishing", "length_m": 52, "beam_m": 11, "height_m": 11},
    "ferry, 52 m": {"shape": "hull", "hull_type": "ferry", "length_m": 52, "beam_m": 11, "height_m": 10},
    "cargo, 75 m": {"shape": "hull", "hull_type": "cargo", "length_m": 75, "beam_m": 12.5, "height_m": 17},
    "ferry, 90 m": {"shape": "hull", "hull_type": "ferry", "length_m": 90, "beam_m": 16, "height_m": 14},
    "cargo, 103 m": {"shape": "hull", "hull_type": "cargo", "length_m": 103, "beam_m": 16, "height_m": 20},
    "cargo, 140 m": {"shape": "hull", "hull_type": "cargo", "length_m": 140, "beam_m": 21, "height_m": 28},
    "coaster.obj, 88 m": {"mesh": "coaster.obj"},
    "ferry.obj, 118 m": {"mesh": "ferry.obj"},
    "freighter.obj, 140 m": {"mesh": "freighter.obj"},
    "tanker.obj, 185 m": {"mesh": "tanker.obj"},
}  # fmt: skip


class Echoes(NamedTuple):
    """Of one ship on one sea: aspects (K,) [degrees from the bow], cross-sections (K,) [dBsm], length of the ship [m]."""

    aspect: Floats
    section: Floats
    length: float

    @property
    def off_beam(self) -> Floats:
        """By how much each aspect is off broadside [degrees]."""
        return np.abs(self.aspect % 180.0 - 90.0)

    @property
    def quartiles(self) -> Floats:
        """Over bow and quarter: aspects over 12 degrees off broadside."""
        return np.asarray(np.percentile(self.section[self.off_beam > AWAY], [25, 50, 75]))

    @property
    def broadside(self) -> float:
        """Mean power within 2 degrees of broadside, over the median of bow and quarter [dB]."""
        power = 10.0 ** (self.section[self.off_beam <= BROADSIDE] / 10.0)
        return float(10.0 * np.log10(power.mean()) - self.quartiles[1])

    @property
    def spread(self) -> float:
        """Standard deviation [dB] of looks within a window, over all windows of bow and quarter."""
        window = np.round(self.aspect / STEP).astype(int)
        away = np.unique(window[self.off_beam > AWAY])
        return float(np.sqrt(np.mean([self.section[window == n].var(ddof=1) for n in away])))


def aspects(per_window: int, abeam: int) -> Floats:
    """So many in each window, and so many more about either broadside [degrees from the bow], at odd places."""
    rng = np.random.default_rng(7)
    place = (np.arange(per_window) + rng.uniform(size=(round(360.0 / STEP), per_window))) / per_window - 0.5
    off = (np.arange(abeam) + rng.uniform(size=(2, abeam))) / max(abeam, 1) - 0.5
    windows = np.arange(len(place))[:, None] * STEP + WINDOW * place
    return np.concatenate([windows.ravel(), (np.array([[90.0], [270.0]]) + 2.0 * BROADSIDE * off).ravel()])


def echoes(body: Mapping[str, Any], sea: str, aspect: Floats) -> Echoes:
    """The cross-sections of a ship of a scene file on one of SEAS, at aspects (K,) [degrees from the bow]."""
    table = {"name": "ship", "position_m": [0, DISTANCE, 0], "course_deg": 180.0, "turn_rate_deg_s": TURN,
             "scattering": "optics", "plating": {}, **body}  # fmt: skip
    if "mesh" in table:
        table["mesh"] = Path(table["mesh"]).name
    scene = rs.load_scene(
        {"radar": {"range_max_m": 6000, "height_m": ANTENNA}, "environment": SEAS[sea], "body": [table]},
        folder=(SCENES / body.get("mesh", "")).parent,
    )
    mesh = scene.bodies[0].mesh
    assert mesh is not None
    length = float(np.ptp(mesh.used_vertices[:, 1]))
    return Echoes(aspect, sections_dbsm(scene, aspect % 360.0 / TURN), length)


def band(length: float) -> tuple[float, float] | None:
    """The band of a ship's length [m]; None: there is none."""
    return next((value for (low, high), value in BANDS.items() if low <= length <= high), None)


def together(seas: Mapping[str, Echoes]) -> Echoes:
    """The echoes over all WAVES."""
    each = [seas[sea] for sea in WAVES]
    aspect, section = (np.concatenate([getattr(one, name) for one in each]) for name in ("aspect", "section"))
    return Echoes(aspect, section, each[0].length)


def row(name: str, seas: Mapping[str, Echoes], looks: Echoes) -> str:
    """A line of the table; looks: those of the spread."""
    limits, way = band(seas[UNDER_WAY].length), seas[UNDER_WAY]
    parts = [" / ".join(f"{value:.0f}" for value in each.quartiles) for each in seas.values()]
    median = round(float(together(seas).quartiles[1]))  # the bands are in whole decibels
    inside = "" if limits is None else "yes" if limits[0] <= median <= limits[1] else "no"
    text = "none" if limits is None else f"{limits[0]:.0f} to {limits[1]:.0f}"
    return f"| {name} | {' | '.join(parts)} | {median} | {text} | {inside} | {way.broadside:+.0f} | {looks.spread:.1f} |"


def plot(name: str, seas: Mapping[str, Echoes], file: Path) -> None:
    """A polar plot of cross-sections over aspects."""
    figure = Figure(figsize=(6, 6))
    axes = figure.add_subplot(projection="polar")
    axes.set(theta_zero_location="N", theta_direction=-1, title=f"{name}, dBsm")
    for sea, each in seas.items():
        order = np.argsort(each.aspect % 360.0)
        angle = np.deg2rad(each.aspect[order])
        axes.plot(angle, np.maximum(each.section[order], FLOOR), ".-", linewidth=0.6, markersize=3, label=sea)
    axes.legend(fontsize="small")
    figure.savefig(file, dpi=110)


def bow_and_quarter(looks: int) -> Floats:
    """So many aspects in each window of bow and quarter [degrees from the bow]."""
    each = aspects(looks, 0)
    return np.asarray(each[np.abs(np.round(each / STEP) * STEP % 180.0 - 90.0) > AWAY])


def measured(name: str, body: Mapping[str, Any], folder: Path) -> tuple[dict[str, Echoes], Echoes]:
    """By sea, and the looks of the spread, from the folder where they are there already."""
    plans = {sea: (sea, aspects(PER_WINDOW, ABEAM if sea == UNDER_WAY else 0)) for sea in SEAS}
    plans["looks"] = UNDER_WAY, bow_and_quarter(LOOKS)
    result = {}
    for plan, (sea, aspect) in plans.items():
        file = folder / f"{name.replace(', ', '-').replace(' ', '')}-{plan}.npz"
        if not file.exists():
            np.savez(file, **echoes(body, sea, aspect)._asdict())
        with np.load(file) as kept:
            result[plan] = Echoes(kept["aspect"], kept["section"], float(kept["length"]))
    return result, result.pop("looks")


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--mesh", action="append", default=[], metavar="NAME=FILE")
    options = parser.parse_intermixed_args(arguments)
    others = {name: {"mesh": file} for name, _, file in (each.partition("=") for each in options.mesh)}
    options.folder.mkdir(exist_ok=True)
    columns = ["ship", *SEAS, "all waves", "band", "inside", "broadside dB", "in 5 degrees dB"]
    print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for name, body in {**SHIPS, **others}.items():
        if not options.names or name in options.names:
            seas, looks = measured(name, body, options.folder)
            print(row(name, seas, looks), flush=True)
            plot(name, seas, options.folder / f"{name.replace(', ', '-').replace(' ', '')}.png")


if __name__ == "__main__":
    main()
