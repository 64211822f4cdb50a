"""The PPI in a size for terminals: messages of the feed update it, and `image` draws it."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.display.palettes import DEFAULT_PALETTE, colour_map
from radar_service.display.picture import HEADING, RING, UNSEEN
from radar_service.display.ppi import Ppi, scan_convert
from radar_service.display.units import DEFAULT_UNIT, Unit, range_text, ring_step
from radar_service.wire import SpokeRows

from .film import faded
from .scans import bright_cells, empty_ppi

Bytes = NDArray[np.uint8]


class TerminalPpi:
    """The echoes of the running epoch.

    range: radius of the picture [m]; None means the whole range of the radar.
    palette: a name of `display.palettes.PALETTES`.
    unit: of ranges and rings.
    """

    def __init__(
        self, dynamic_range_db: float = 60.0, range: float | None = None, head_up: bool = False,
        palette: str = DEFAULT_PALETTE, unit: Unit = DEFAULT_UNIT,
    ) -> None:  # fmt: skip
        self.ppi: Ppi | None = None
        self.hello: dict[str, Any] = {}
        self.scan, self.heading = 0, 0.0
        self._dynamic_range_db, self._range, self._head_up = dynamic_range_db, range, head_up
        self._colours, self._unit = colour_map(palette), unit

    def take(self, message: dict[str, Any]) -> None:
        """Adds a message. Raises FeedError if the radar is too large; ValueError, TypeError or LookupError if it is invalid."""
        if message["type"] == "hello" and message["epoch"] != self.hello.get("epoch"):
            self.hello, self.ppi = message, empty_ppi(message)
        elif message["type"] == "spokes" and self.ppi is not None:
            rows = SpokeRows.of(message)
            self.ppi.add(rows.index, rows.samples, rows.number)
            self.scan = int(message["scan"])
            known = rows.heading[~np.isnan(rows.heading)]  # the radar may have lost it
            self.heading = float(known[-1]) if len(known) else self.heading

    @property
    def caption(self) -> str:
        """Scene, radar, range and heading in one line."""
        if self.ppi is None:
            return "no radar yet"
        radius = self._radius(self.ppi)
        up = "head up" if self._head_up else "north up"
        return (
            f"{self.hello['scene']['name']}, {self.hello['radar']['name']}: range {range_text(radius, self._unit)}, "
            f"rings {range_text(ring_step(radius, self._unit), self._unit)}, {up}, "
            f"heading {round(math.degrees(self.heading), 1) % 360.0:05.1f}\N{DEGREE SIGN}, scan {self.scan}"
        )

    def image(self, size: int) -> Bytes:
        """Draws the picture (size, size, 3): fading echoes, range rings and heading line; azimuths without a spoke are grey."""
        if self.ppi is None:
            return np.zeros((size, size, 3), dtype=np.uint8)
        up = round(math.degrees(self.heading)) * math.pi / 180.0 if self._head_up else 0.0  # whole degrees: few index maps
        radius = self._radius(self.ppi)
        mode = "peak" if 2.0 * radius / size > self.ppi.range_step else "bilinear"
        bright = faded(
            bright_cells(self.ppi, self.hello["encoding"], self._dynamic_range_db),
            np.maximum(self.ppi.age, 0) / len(self.ppi.number),
        )
        shown = scan_convert(bright, self.ppi.range_first, self.ppi.range_step, size, radius, up, mode)  # type: ignore[arg-type]
        image = self._colours[np.rint(shown).astype(np.uint8)]
        self._annotate(image, radius, up)
        return image

    def _radius(self, ppi: Ppi) -> float:
        return self._range or ppi.range_end

    def _annotate(self, image: Bytes, radius: float, up: float) -> None:
        """Paints rings, heading line and grey azimuths; rings and lines do not cover a brighter echo."""
        assert self.ppi is not None
        size, rows = len(image), len(self.ppi.number)
        offset = (np.arange(size) + 0.5 - size / 2.0) * (2.0 * radius / size)
        distance, bearing = np.hypot(offset[:, None], offset), np.arctan2(offset, -offset[:, None]) + up
        row = np.rint(bearing * (rows / (2.0 * math.pi))).astype(np.int64) % rows
        image[~self.ppi.filled[row]] = UNSEEN
        step = ring_step(radius, self._unit)
        ring = np.abs((distance / step + 0.5) % 1.0 - 0.5) * step < radius / size
        image[ring] = np.maximum(image[ring], np.array(RING, dtype=np.uint8) // 2)
        astern = np.cos(bearing - self.heading) < 0
        bow = (np.abs(distance * np.sin(bearing - self.heading)) < radius / size) & ~astern
        image[bow] = np.maximum(image[bow], np.array(HEADING, dtype=np.uint8) // 3)
        image[distance > radius] = 0


def half_blocks(image: Bytes) -> list[str]:
    """Returns lines of text that show an image (H, W, 3) in 24-bit colour. A character shows two pixels, one above the other."""
    if len(image) % 2:
        image = np.concatenate([image, np.zeros_like(image[:1])])
    return [_line(image[k], image[k + 1]) for k in range(0, len(image), 2)]


def _line(upper: Bytes, lower: Bytes) -> str:
    colours = np.concatenate([upper, lower], axis=1)
    begins = np.flatnonzero(np.any(colours != np.roll(colours, 1, axis=0), axis=1))
    begins = np.union1d(begins, [0])
    ends = np.append(begins[1:], len(colours))
    runs = (
        f"\x1b[38;2;{';'.join(map(str, colours[a, :3]))};48;2;{';'.join(map(str, colours[a, 3:]))}m" + "\u2580" * (b - a)
        for a, b in zip(begins, ends, strict=True)
    )
    return "".join(runs) + "\x1b[0m"
