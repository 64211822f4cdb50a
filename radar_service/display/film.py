"""Films of pictures: an animated GIF."""

from collections.abc import Iterable
from functools import lru_cache
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from radar_service.display.palettes import DEFAULT_PALETTE, PALETTES, colour_map
from radar_service.display.picture import HEADING, NORTH, RING, SCALE, SURROUND, UNSEEN, Page
from radar_service.terminal import written

MAX_FPS = 25  # browsers play a GIF of 50 and more at 10
MAP_LEVELS, LINE_BLENDS = 202, 13  # colours of the map, and of each line over the sea: 256 with SURROUND and UNSEEN
GIF_HEADER = 13  # bytes of a GIF before its palette; the low three bits of the 11th are the palette's length
LOOP = b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"  # without end


@lru_cache(maxsize=len(PALETTES))
def _gif_palette(palette: str) -> Image.Image:
    """The 256 colours of a GIF: those of the map, thinned, and those of the lines as they fade into the sea."""
    levels = colour_map(palette)[np.rint(np.linspace(0, 255, MAP_LEVELS)).astype(int)]
    shares = np.linspace(1.0, 0.15, LINE_BLENDS)[:, None]
    lines = [shares * np.array(colour) + (1 - shares) * levels[0] for colour in (RING, SCALE, HEADING, NORTH)]
    colours = np.concatenate([levels, *np.rint(lines), [SURROUND, UNSEEN]]).astype(np.uint8)
    image = Image.new("P", (1, 1))
    image.putpalette(colours.tobytes())
    return image


def write_gif(path: Path, frames: Iterable[Page], fps: int, palette: str = DEFAULT_PALETTE) -> None:
    """Writes an animation that repeats. Frames are encoded one by one.

    palette: of the frames. fps: 1 to MAX_FPS. A GIF counts hundredths of a second, so the durations of frames differ by up
    to a hundredth.
    """
    with written(path) as part, part.open("wb") as file:
        for count, frame in enumerate(frames, 1):
            hundredths = round(100 * count / fps) - round(100 * (count - 1) / fps)
            header, block = _gif_parts(frame, 10 * hundredths, palette)
            file.write(header + LOOP + block if count == 1 else block)
        file.write(b";")


def _gif_parts(frame: Page, duration_ms: int, palette: str) -> tuple[bytes, bytes]:
    """Header with palette, and image block without the trailer, of the GIF of one frame. A film is a header and blocks."""
    out = BytesIO()
    indexed = frame.quantize(palette=_gif_palette(palette), dither=Image.Dither.NONE)
    indexed.save(out, "GIF", duration=duration_ms, optimize=False)
    data = out.getvalue()
    split = GIF_HEADER + 3 * 2 ** ((data[10] & 7) + 1)
    return data[:split], data[split:-1]
