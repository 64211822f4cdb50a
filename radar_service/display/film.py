"""Pictures one after the other in a file: an animated GIF, or an MP4 where ffmpeg is on the PATH."""

import shutil
import subprocess
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from radar_service.display.picture import HEADING, NORTH, RING, SCALE, SEA, SURROUND, UNSEEN, Page, colour_map

MAX_FPS = 25  # browsers play a GIF of 50 and more at 10 instead
LEVELS, BLENDS = 202, 13  # of the map, and of each line's colour over the sea: 256 with SURROUND and UNSEEN
HEAD = 13  # bytes of a GIF before its palette; the low three bits of the 11th tell how long that is
LOOP = b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"  # for ever


@contextmanager
def _whole(path: Path) -> Iterator[Path]:
    """Where to write what appears at `path` once it is whole."""
    part = path.with_name(f".{path.name}.part")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


@lru_cache(maxsize=1)
def _palette() -> Image.Image:
    """The 256 colours of a GIF: those of the map, thinned, and those of the lines as they fade into the sea."""
    levels = colour_map()[np.rint(np.linspace(0, 255, LEVELS)).astype(int)]
    shares = np.linspace(1.0, 0.15, BLENDS)[:, None]
    lines = [shares * np.array(colour) + (1 - shares) * np.array(SEA) for colour in (RING, SCALE, HEADING, NORTH)]
    colours = np.concatenate([levels, *np.rint(lines), [SURROUND, UNSEEN]]).astype(np.uint8)
    image = Image.new("P", (1, 1))
    image.putpalette(colours.tobytes())
    return image


def write_gif(path: Path, frames: Iterable[Page], fps: int) -> None:
    """Write an animation that repeats. Frames are taken and written one by one.

    fps: 1 to MAX_FPS. A GIF counts hundredths of a second: frames last a hundredth more or less where they must.
    """
    with _whole(path) as part, part.open("wb") as file:
        for count, frame in enumerate(frames, 1):
            hundredths = round(100 * count / fps) - round(100 * (count - 1) / fps)
            head, block = _gif_parts(frame, 10 * hundredths)
            file.write(head + LOOP + block if count == 1 else block)
        file.write(b";")


def _gif_parts(frame: Page, duration_ms: int) -> tuple[bytes, bytes]:
    """Head with palette, and the rest without the end, of the GIF of one frame: a film is a head and many such rests."""
    out = BytesIO()
    frame.quantize(palette=_palette(), dither=Image.Dither.NONE).save(out, "GIF", duration=duration_ms, optimize=False)
    data = out.getvalue()
    split = HEAD + 3 * 2 ** ((data[10] & 7) + 1)
    return data[:split], data[split:-1]


def ffmpeg() -> str:
    """Where ffmpeg is. Raises OSError with the remedy where it is not."""
    found = shutil.which("ffmpeg")
    if found is None:
        raise OSError(
            "MP4 wants ffmpeg on the PATH, and there is none; install it (apt-get install ffmpeg), or ask for .gif"
        )
    return found


def write_mp4(path: Path, frames: Iterable[Page], fps: int) -> None:
    """Write a film with ffmpeg. Raises OSError where there is no ffmpeg, or it fails."""
    process = None
    with _whole(path) as part:
        try:
            for frame in frames:
                process = process or _encoder(part, frame.size, fps)
                assert process.stdin is not None
                process.stdin.write(frame.convert("RGB").tobytes())
            _finish(process)
        except BrokenPipeError:
            _finish(process)  # which says why it went
        finally:
            if process:
                process.kill()
                process.communicate()


def _encoder(path: Path, size: tuple[int, int], fps: int) -> subprocess.Popen[bytes]:
    """ffmpeg taking raw pictures; sides are made even, for players want their colours at half the resolution."""
    command = [
        ffmpeg(), "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}",
        "-r", str(fps), "-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-f", "mp4",
        "-movflags", "+faststart", str(path),
    ]  # fmt: skip
    return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)


def _finish(process: subprocess.Popen[bytes] | None) -> None:
    if process is None:
        raise OSError("a film of no pictures")
    _, said = process.communicate()
    if process.returncode:
        reason = said.decode(errors="replace").strip()[-500:]
        raise OSError(f"ffmpeg ended with {process.returncode}: {reason or 'without a word'}")
