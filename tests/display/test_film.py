"""Films: as many pictures as were given, each its time, in the right colours; whole or not at all."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from radar_service.display.film import ffmpeg, write_gif, write_mp4
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


def test_what_is_interrupted_leaves_nothing_and_spares_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program(tmp_path, monkeypatch, 'for last; do :; done\nexec cat > "$last"')
    for write, name in ((write_gif, "a.gif"), (write_mp4, "a.mp4")):
        (tmp_path / name).write_text("an older film")
        with pytest.raises(KeyboardInterrupt):
            write(tmp_path / name, broken(), 10)
        assert (tmp_path / name).read_text() == "an older film"
    assert sorted(os.listdir(tmp_path)) == ["a.gif", "a.mp4", "ffmpeg"]


def program(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """An ffmpeg that does what the script says, alone on the PATH with the system's own programs."""
    (folder / "ffmpeg").write_text(f"#!/bin/sh\n{script}\n")
    (folder / "ffmpeg").chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/bin:/usr/bin")


def test_an_mp4_is_what_ffmpeg_makes_of_the_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, monkeypatch, 'for last; do :; done\necho "$@" > "$0.said"\nexec cat > "$last"')
    write_mp4(tmp_path / "a.mp4", frames(3), fps=12)
    assert (tmp_path / "a.mp4").read_bytes() == b"".join(frame.tobytes() for frame in frames(3))
    text = (tmp_path / "ffmpeg.said").read_text()
    assert "-s 5x263 -r 12 -i -" in text and "yuv420p" in text


@pytest.mark.parametrize("script", ["echo no such codec >&2; exit 3", "cat > /dev/null; echo no such codec >&2; exit 3"])
def test_an_ffmpeg_that_fails_is_quoted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    program(tmp_path, monkeypatch, script)
    with pytest.raises(OSError, match="ffmpeg ended with 3: no such codec"):
        write_mp4(tmp_path / "a.mp4", frames(50), 10)
    assert not (tmp_path / "a.mp4").exists()


def test_missing_ffmpeg_is_reported_with_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(OSError, match=r"install it .* or choose \.gif"):
        ffmpeg()
