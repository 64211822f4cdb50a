"""The short modules of display, each under its name."""

import io
import math
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from radar_service.display.film import write_gif
from radar_service.display.last_scan import last_scan_png
from radar_service.display.palettes import colour_map
from radar_service.display.picture import HEADING, NORTH, RING, SCALE, SEA, SURROUND, UNSEEN
from radar_service.display.video import Controls, layout
from radar_service.scene_file.load import load_scene


# film: films: as many pictures as were given, each its time, in the right colours; whole or not at all.
def frames(count: int) -> Iterator[Image.Image]:
    """Every colour of the map and of the lines, turned by ten rows from picture to picture."""
    rows = np.concatenate([colour_map(), [RING, SCALE, HEADING, NORTH, SEA, SURROUND, UNSEEN]]).astype(np.uint8)
    for k in range(count):
        yield Image.fromarray(np.repeat(np.roll(rows, 10 * k, axis=0)[:, None], 5, axis=1))


def shown(path: Path) -> tuple[list[NDArray[np.uint8]], list[int]]:
    """The pictures of a GIF and how long each stands [ms]."""
    pictures, standing = [], []
    with Image.open(path) as film:
        for k in range(film.n_frames):  # type: ignore[attr-defined]
            film.seek(k)
            pictures.append(np.asarray(film.convert("RGB")))
            standing.append(film.info["duration"])
        assert film.info["loop"] == 0
    return pictures, standing


def test_a_gif_has_the_pictures_their_times_and_their_colours(tmp_path: Path) -> None:
    write_gif(tmp_path / "a.gif", frames(7), fps=7)
    pictures, standing = shown(tmp_path / "a.gif")
    assert standing == [140, 150, 140, 140, 140, 150, 140]  # a second in all; GIF counts hundredths
    step = np.abs(np.diff(colour_map().astype(int), axis=0)).max()  # of the map; 202 of its 256 colours are kept
    for picture, given in zip(pictures, frames(7), strict=True):
        assert np.abs(picture.astype(int) - np.asarray(given)).max() <= step
    lines = np.roll(pictures[1], -10, axis=0)[256:, 0].tolist()
    assert lines == [list(colour) for colour in (RING, SCALE, HEADING, NORTH, SEA, SURROUND, UNSEEN)]
    assert os.listdir(tmp_path) == ["a.gif"]


def broken() -> Iterator[Image.Image]:
    yield from frames(2)
    raise KeyboardInterrupt


def test_what_is_interrupted_leaves_nothing_and_spares_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "a.gif").write_text("an older film")
    with pytest.raises(KeyboardInterrupt):
        write_gif(tmp_path / "a.gif", broken(), 10)
    assert (tmp_path / "a.gif").read_text() == "an older film" and os.listdir(tmp_path) == ["a.gif"]


# last_scan: the picture of the last scan.
SCENE = load_scene({"radar": {"azimuths": 24, "beamwidth_deg": 20, "range_max_m": 200}, "own_ship": {"heading_deg": 90}})
NOISE = 1e-15  # W
BY_HAND = Controls(gain_auto=False, sea_auto=False)  # auto sea takes an echo all along a spoke for clutter


def picture(rows: list[int], echo_row: int | None = None) -> np.ndarray:
    """Levels (200, 200, 3) of a picture of these rows of noise, one of them with a strong echo all along."""
    bins = SCENE.radar.bins
    to = layout(bins, SCENE.radar.range_step / 2, SCENE.radar.range_step)
    last_rows = [
        (np.array([row]), np.full((1, bins), 1e6 * NOISE if row == echo_row else NOISE, np.float32), None) for row in rows
    ]
    png = last_scan_png(last_rows, 24, to, BY_HAND, NOISE, title="x", size=200, range_max=None, heading=math.radians(90))
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


def at(levels: np.ndarray, bearing_deg: float, share: float = 0.37) -> np.ndarray:
    """The mean colour around a place, at a share of the range, which ends somewhat inside the picture."""
    x = 100 + 90 * share * math.sin(math.radians(bearing_deg))
    y = 100 - 90 * share * math.cos(math.radians(bearing_deg))
    return levels[round(y) - 2 : round(y) + 3, round(x) - 2 : round(x) + 3].mean(axis=(0, 1))


def test_an_echo_shows_at_its_bearing() -> None:
    levels = picture(list(range(24)), echo_row=15)  # 225 degrees
    assert at(levels, 225).max() > 150 and at(levels, 45).max() < 60


def test_interference_rejection_compares_rows_across_batches() -> None:
    """A pulse in row 11 alone, the last of a batch or the first of one, or all rows at once: the same picture without it."""
    to, controls = layout(64, 1.0, 2.0), Controls(gain=50.0, gain_auto=False, sea_auto=False, interference_rejection=True)
    power = np.full((24, 64), NOISE / 2, np.float32)
    quiet = power.copy()
    power[11, 30] = 1e6 * NOISE

    def drawn(power: np.ndarray, *edges: int) -> bytes:
        parts = [(np.arange(a, b), power[a:b], None) for a, b in zip((0, *edges), (*edges, 24), strict=True)]
        return last_scan_png(parts, 24, to, controls, NOISE, title="", size=100, range_max=None, heading=0.0)

    assert drawn(power) == drawn(power, 11) == drawn(power, 12) == drawn(power, 5, 12, 13) == drawn(quiet)


def test_scan_correlation_removes_what_the_scan_before_has_not() -> None:
    to, controls = layout(64, 1.0, 2.0), Controls(gain=50.0, gain_auto=False, sea_auto=False, scan_correlation=True)
    quiet = np.full((24, 64), NOISE / 2, np.float32)
    power = quiet.copy()
    power[11, 30] = 1e6 * NOISE

    def drawn(power: np.ndarray, earlier: np.ndarray | None) -> bytes:
        rows = [(np.arange(24), power, earlier)]
        return last_scan_png(rows, 24, to, controls, NOISE, title="", size=100, range_max=None, heading=0.0)

    assert drawn(power, quiet) == drawn(quiet, None) != drawn(power, power) == drawn(power, None)


def test_azimuths_without_a_row_are_grey() -> None:
    levels = picture(list(range(12)))
    east, west = at(levels, 60), at(levels, 240)
    assert np.ptp(west) < 6 < np.ptp(east)  # grey has equal parts, the colour of the sea has not
