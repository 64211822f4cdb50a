"""The palettes of the radar picture: colours of echoes by strength. `clients/web/palettes.js` is the same table for the page.

A stop is a level, 0 to 255, and its colour. Level 0 is the sea without an echo; colours between levels 1 and up are interpolated.
"""

from functools import lru_cache
from itertools import starmap

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Stops = tuple[tuple[int, str], ...]

# Lightness rises along every palette, so that no one needs to distinguish hues. `multicolour` rises fast at its start: an echo
# 3 dB over the threshold of auto gain has a contrast of 3:1 to the sea. Its hues run from blue to yellow through green, which
# the common colour blindnesses distinguish.
PALETTES: dict[str, Stops] = {
    "multicolour": (
        (0, "#04121d"), (1, "#0c2a50"), (12, "#2468b4"), (28, "#2080b4"), (48, "#1f9894"),
        (70, "#44ae66"), (92, "#88b83a"), (122, "#c8c02a"), (180, "#f2da58"), (255, "#ffffd0"),
    ),
    "dusk": ((0, "#04121d"), (1, "#37483a"), (110, "#c8a93c"), (255, "#fff6b8")),
    "day": ((0, "#0b2c4d"), (1, "#4d6472"), (110, "#e3cc55"), (255, "#fffbd6")),
    "night": ((0, "#000000"), (1, "#2a1409"), (110, "#8a4a1c"), (255, "#d99a5c")),
    "phosphor": ((0, "#010a05"), (1, "#073d1c"), (110, "#1fb95b"), (255, "#d8ffe2")),
}  # fmt: skip
DEFAULT_PALETTE = "multicolour"


@lru_cache(maxsize=len(PALETTES))
def colour_map(palette: str = DEFAULT_PALETTE) -> Bytes:
    """Red, green and blue (256, 3) of each level, from the sea at 0 to the lightest at 255; read-only.

    Raises ValueError for an unknown palette.
    """
    if palette not in PALETTES:
        raise ValueError(f'palette: "{palette}" is not one of {", ".join(PALETTES)}')
    sea, *stops = PALETTES[palette]
    levels, colours = [level for level, _ in stops], np.array(list(starmap(_rgb, stops)), dtype=np.float64)
    table = np.stack([np.interp(np.arange(256), levels, channel) for channel in colours.T], axis=1)
    table[0] = _rgb(*sea)
    result: Bytes = np.floor(table + 0.5).astype(np.uint8)  # as Math.round of the page
    result.setflags(write=False)
    return result


def _rgb(_: int, colour: str) -> tuple[int, int, int]:
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue
