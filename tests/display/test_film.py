"""Films: as many pictures as were given, each its time, in the right colours; whole or not at all."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from radar_service.display.film import write_gif
from radar_service.display.palettes import colour_map
from radar_service.display.picture import HEADING, NORTH, RING, SCALE, SEA, SURROUND, UNSEEN


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
