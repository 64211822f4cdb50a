"""Bodies that stand out of the clutter are found by eye, at default settings, in the README's scene and all shipped ones.

The picture is that of 600 pixels without its lines, which are bright too: the disc has 538 pixels. Contrast is that of WCAG 2.2,
1.4.11: 3:1 or more. What counts is the brightest pixel at the body's place against the median of 20 pixels around it.
The place is that of the truth at the moment when the beam passes it. The signal-to-clutter ratio comes from other runs: the body
alone, without sea and noise, against the scene without any ship or buoy, to which the others' own fields are added.
"""

import tomllib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.display.palettes import colour_map
from radar_service.display.ppi import image_position, scan_convert
from radar_service.display.video import Controls, display_video, layout
from radar_service.records.truth import BodyTruth
from radar_service.world.seaway import significant_wave_height
from tests.display.test_palettes import luminance
from tests.test_readme import blocks

FOLDER = Path(__file__).parents[1] / "scenes"
NAMES = ["README", *sorted(path.stem for path in FOLDER.glob("*.toml"))]
DISC = 538  # pixels of the disc in a picture of 600
SPREAD = (
    3.0  # pixels from the place, besides half the body's length: interpolation over cells and pixels, and the ship's way
)
AROUND = 10.0  # pixels from the place to the 20 around, besides half the body's length
MIN_SCR_DB, MIN_CONTRAST = 15.0, 3.0
NEAR = 50.0  # m: coasts, quays and towns have the origin of their mesh at own ship, which is no place of theirs

Source = Mapping[str, Any]
Floats = NDArray[np.float64]


class Place(NamedTuple):
    """A body in the picture: row and column [pixels], radii of its own pixels and of those around."""

    row: float
    column: float
    own: float
    around: float

    def distance(self, rows: Floats, columns: Floats) -> Floats:
        """From here to pixels [pixels]."""
        return np.asarray(np.hypot(rows - self.row, columns - self.column))


def source_of(name: str) -> dict[str, Any]:
    return tomllib.loads(blocks("toml")[0] if name == "README" else (FOLDER / f"{name}.toml").read_text())


def scanned(
    source: Source, bodies: list[Any], environment: Source, fidelity: str = "balanced"
) -> tuple[rs.Simulator, rs.Scan]:
    scene = rs.load_scene({**source, "body": bodies, "environment": environment}, folder=FOLDER)
    simulator = rs.Simulator(scene, fidelity)
    return simulator, simulator.scan()


def swell(environment: Source) -> bool | dict[str, float]:
    """The waves that move ships, without the sea state that they come from."""
    if environment.get("seaway", False) is not True:
        return environment.get("seaway", False)
    return {"height_m": significant_wave_height(environment["sea_state"]), "from_deg": environment.get("wind_from_deg", 0.0)}


def seen_bodies(simulator: rs.Simulator, scan: rs.Scan) -> list[BodyTruth]:
    """The truth of each body at the moment when the beam passes the bearing that it has at the start of the scan."""
    start = simulator.truth(float(scan.time[0])).bodies
    rows = [round(body.azimuth / (2.0 * np.pi) * len(scan.time)) % len(scan.time) for body in start]
    return [simulator.truth(float(scan.time[row])).bodies[k] for k, row in enumerate(rows)]


def contrast(bright: Floats, place: Place) -> float:
    """Contrast of the brightest pixel at a place against the median of 20 evenly spaced ones around it."""
    turn = np.arange(20) * (2.0 * np.pi / 20)
    rows, columns = (np.rint(at).astype(int) for at in (
        place.row + place.around * np.cos(turn), place.column + place.around * np.sin(turn)))  # fmt: skip
    inside = np.hypot(rows - DISC / 2, columns - DISC / 2) < DISC / 2  # beyond the edge of the radar there is no picture
    around = np.median(bright[rows[inside], columns[inside]])
    own = bright[place.distance(*np.indices(bright.shape).astype(float)) <= place.own].max()
    return float((own + 0.05) / (around + 0.05))


@pytest.mark.parametrize("most", [2, pytest.param(100, marks=pytest.mark.study)])
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.study) if name in ("aids", "coast", "harbour", "far-target") else name
        for name in NAMES
    ],
)
def test_bodies_that_stand_out_of_the_clutter_are_found_by_eye(name: str, most: int) -> None:
    """The suite looks for two bodies of a scene, evenly chosen; the others are there all the same. The harbour takes 10 s,
    and the far target 2."""
    source = source_of(name)
    bodies, environment = source["body"], source.get("environment", {})
    simulator, scan = scanned(source, bodies, environment, "auto")
    to = layout(len(scan.range), float(scan.range[0]), scan.range_step)
    video = display_video(scan.power, to, Controls(), simulator.noise_power)
    levels = np.rint(scan_convert(video, to.first, to.step, DISC, to.range, interpolation="peak")).astype(np.uint8)
    bright = luminance(colour_map()[levels].astype(np.uint8))

    position = partial(image_position, size=DISC, range_max=to.range)
    rows, columns = position(scan.range, scan.azimuth[:, None])  # of the cells
    truths = seen_bodies(simulator, scan)
    sought = [k for k, truth in enumerate(truths) if truth.visible and truth.range > NEAR]
    sought = sought[:: -(-len(sought) // most)]
    calm = environment | {"noise": False, "sea_state": 0, "rain_mm_h": 0, "seaway": swell(environment)}
    alone = {k: scanned(source, [bodies[k]], calm)[1].field for k in sought}
    _, rest = scanned(source, [body for k, body in enumerate(bodies) if k not in sought], environment, "auto")
    together = rest.field + sum(alone.values())
    results = {}
    for k in sought:
        half = simulator.scene.bodies[k].length / 2.0 * DISC / (2.0 * to.range)
        place = Place(*map(float, position(truths[k].range, truths[k].azimuth)), SPREAD + half, AROUND + half)
        distance = place.distance(rows, columns)
        near = distance <= place.around
        signal = np.abs(alone[k][distance <= place.own]).max() ** 2
        clutter = np.mean(np.abs(together[near] - alone[k][near]) ** 2)
        scr_db = 10.0 * np.log10(signal / max(clutter, simulator.noise_power))
        results[bodies[k]["name"]] = scr_db, contrast(bright, place)
    print("\n".join(f"{body}: {scr_db:.1f} dB, {found:.1f}:1" for body, (scr_db, found) in results.items()))
    strong = {body: found for body, (scr_db, found) in results.items() if scr_db > MIN_SCR_DB}
    assert strong and {body: found for body, found in strong.items() if found < MIN_CONTRAST} == {}
