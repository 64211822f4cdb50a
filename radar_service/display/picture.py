"""Pictures of the PPI: colours, range rings, bearing scale and heading line, as an image and as a PNG."""

from collections.abc import Callable
from io import BytesIO
from math import cos, sin
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from radar_service.display.palettes import DEFAULT_PALETTE, colour_map
from radar_service.display.ppi import Interpolation, scan_convert
from radar_service.display.units import DEFAULT_UNIT, Unit, range_text, ring_step
from radar_service.numerics import Flags

Bytes = NDArray[np.uint8]
Colour = tuple[int, int, int]
Draw = ImageDraw.ImageDraw
Page = Image.Image  # a drawn picture

SEA: Colour = (4, 18, 29)  # of the default palette
UNSEEN: Colour = (38, 38, 42)  # grey: no spoke yet, which differs from no echo
SURROUND: Colour = (0, 0, 0)
RING: Colour = (92, 116, 136)
SCALE: Colour = (150, 170, 186)
HEADING: Colour = (255, 255, 255)
NORTH: Colour = (255, 176, 64)
MIN_SIZE, MAX_SIZE = 64, 4096


def picture_from_power(
    power: NDArray[np.floating[Any]], dynamic_range_db: float = 60.0, reference: float | None = None
) -> Bytes:
    """Brightness 0 to 255 of cells (..., N) of power [W]: 255 at `reference` [W] and above, 0 at dynamic_range_db below it.

    reference: default the maximum. Raises ValueError where power is negative or not finite, or the scale is empty.
    """
    if power.size and not (power.min() >= 0 and np.isfinite(power.max())):
        raise ValueError("power: it has negative or non-finite watts; detect the field first (its squared magnitude)")
    if not dynamic_range_db > 0:
        raise ValueError(f"dynamic_range_db: {dynamic_range_db}; a picture spans more than 0 dB")
    top = float(power.max(initial=0.0)) if reference is None else reference
    if not top > 0:
        return np.zeros(power.shape, dtype=np.uint8)
    floor_power = top * 10.0 ** (-dynamic_range_db / 10.0)
    share = 1.0 + 10.0 * np.log10(np.maximum(power, floor_power) / top) / dynamic_range_db
    bright: Bytes = np.rint(255.0 * np.clip(share, 0.0, 1.0)).astype(np.uint8)
    return bright


class Drawing(TypedDict, total=False):
    """Options of a picture; `render_image` explains them."""

    range_max: float | None
    size: int
    heading: float | None
    head_up: bool
    title: str
    filled: Flags | None
    interpolation: Interpolation | None
    palette: str
    unit: Unit


def render_png(picture: Bytes, range_first: float, range_step: float, **drawing: Unpack[Drawing]) -> bytes:
    """The PNG of the image from `render_image`; same arguments."""
    out = BytesIO()
    render_image(picture, range_first, range_step, **drawing).save(out, "PNG", compress_level=4)
    return out.getvalue()


def render_image(
    picture: Bytes,
    range_first: float,
    range_step: float,
    *,
    range_max: float | None = None,
    size: int = 900,
    heading: float | None = None,
    head_up: bool = False,
    title: str = "",
    filled: Flags | None = None,
    interpolation: Interpolation | None = None,
    palette: str = DEFAULT_PALETTE,
    unit: Unit = DEFAULT_UNIT,
) -> Page:
    """An image of size x size pixels of a polar picture (A, N) of brightness 0 to 255, with samples as in `scan_convert`.

    range_max: the radius [m], default the far edge of the last cell. heading: of the heading line [rad], None or NaN for no
    line; head_up: turns it to the top. filled: (A,) rows that have a spoke; the others are grey. interpolation: default `peak`
    where pixels are larger than range cells, so that each target is drawn, else `bilinear`. palette: a name of
    `palettes.PALETTES`. unit: of ranges and rings.
    Raises ValueError for a picture that is not bytes, for a size outside 64 to 4096, and for head_up without a heading.
    """
    if picture.dtype != np.uint8:
        raise ValueError(f"picture: {picture.dtype}; brightness is uint8, 0 to 255 (see picture_from_power)")
    if not MIN_SIZE <= size <= MAX_SIZE:
        raise ValueError(f"size: {size} pixels; {MIN_SIZE} to {MAX_SIZE} are allowed")
    heading = None if heading is None or np.isnan(heading) else heading
    if head_up and heading is None:
        raise ValueError("head_up: needs a heading, and none is given; pass heading [rad]")
    radius = range_max if range_max is not None else range_first + (picture.shape[1] - 0.5) * range_step
    up = float(heading) if head_up and heading is not None else 0.0
    dial = _Dial(size, up)
    mode = interpolation or ("peak" if 2.0 * radius / dial.width > range_step else "bilinear")
    bright = scan_convert(picture, range_first, range_step, dial.width, radius, up, mode)
    disc = colour_map(palette)[np.rint(bright).astype(np.uint8)]
    if filled is not None and not filled.all():
        unseen = scan_convert((~filled[:, None]).astype(np.uint8), radius / 2.0, radius, dial.width, radius, up)
        disc[unseen > 0.5] = UNSEEN
    image = dial.framed(disc)
    image = dial.overlay(image, lambda draw: _lines(draw, dial, radius, heading, unit))
    orientation = "head up" if head_up else "north up"
    _labels(ImageDraw.Draw(image), dial, radius, heading, [title, orientation], unit)
    return image


RING_LABELS = np.radians(285.0)  # bearing of the labels of the rings, clockwise from the top of the page


class _Dial:
    """The geometry of the page: a disc of `width` pixels in the middle of a square, with bearing `up` [rad] at the top."""

    def __init__(self, size: int, up: float) -> None:
        self.size, self.up = size, up
        self.margin = max(4, round(size * 0.052))
        self.width = size - 2 * self.margin
        self.middle, self.radius = size / 2.0, self.width / 2.0
        self.font = ImageFont.load_default(max(8.0, size / 68.0))

    def position(self, share: float, bearing: float, outward: float = 0.0) -> tuple[float, float]:
        """Page coordinates of a share of the radius along a true bearing [rad], shifted outward by some pixels."""
        angle, distance = bearing - self.up, share * self.radius + outward
        return self.middle + distance * sin(angle), self.middle - distance * cos(angle)

    def framed(self, disc: Bytes) -> Image.Image:
        """The disc, cut to a circle, on its page."""
        offset = np.arange(self.width) + 0.5 - self.radius
        disc[np.hypot(offset[:, None], offset) > self.radius] = SURROUND
        page = Image.new("RGB", (self.size, self.size), SURROUND)
        page.paste(Image.fromarray(disc), (self.margin, self.margin))
        return page

    def overlay(self, image: Image.Image, paint: Callable[[Draw], None]) -> Image.Image:
        """The image with lines over it, painted at twice the size and reduced: Pillow's own lines are jagged."""
        layer = Image.new("RGBA", (2 * self.size, 2 * self.size), (0, 0, 0, 0))
        paint(ImageDraw.Draw(layer))
        return Image.alpha_composite(image.convert("RGBA"), layer.reduce(2)).convert("RGB")


def _lines(draw: Draw, dial: _Dial, range_max: float, heading: float | None, unit: Unit) -> None:
    """Paints range rings, bearing ticks, heading line and north mark at twice the size."""
    step = ring_step(range_max, unit)
    for distance in np.append(np.arange(step, range_max * (1 - 1e-9), step), range_max):
        radius, middle = 2.0 * dial.radius * distance / range_max, 2 * dial.middle
        box = (middle - radius, middle - radius, middle + radius, middle + radius)
        draw.ellipse(box, outline=(*RING, 255 if distance == range_max else 120), width=2)
    for degrees in range(0, 360, 10):
        bearing, length = np.radians(degrees), dial.size * (0.011 if degrees % 30 == 0 else 0.006)
        _line(draw, dial.position(1.0, bearing), dial.position(1.0, bearing, length), (*SCALE, 255))
    if heading is not None:
        _line(draw, dial.position(0.0, heading), dial.position(1.0, heading), (*HEADING, 150))
    tip, side = dial.size * 0.014, 0.018
    arrow = [dial.position(1.0, 0.0), dial.position(1.0, side, tip), dial.position(1.0, -side, tip)]
    draw.polygon([(2 * x, 2 * y) for x, y in arrow], fill=(*NORTH, 255))


def _line(draw: Draw, start: tuple[float, float], end: tuple[float, float], fill: tuple[int, int, int, int]) -> None:
    draw.line([(2 * start[0], 2 * start[1]), (2 * end[0], 2 * end[1])], fill=fill, width=2)


def _labels(
    draw: Draw, dial: _Dial, range_max: float, heading: float | None, corners: list[str], unit: Unit
) -> None:  # fmt: skip
    """Writes bearings, ring distances, title, orientation and range."""
    outward = dial.margin * 0.6
    for degrees in range(0, 360, 30):
        label, colour = ("N", NORTH) if degrees == 0 else (f"{degrees:03d}", SCALE)
        draw.text(dial.position(1.0, np.radians(degrees), outward), label, fill=colour, font=dial.font, anchor="mm")
    step = ring_step(range_max, unit)
    for distance in np.arange(step, range_max * 0.97, step):  # closer to the rim a label would overlap it
        position = dial.position(distance / range_max, dial.up + RING_LABELS)
        draw.text(
            position, range_text(distance, unit), fill=SCALE, font=dial.font, anchor="mm", stroke_width=2, stroke_fill=SEA
        )
    near, far = dial.size * 0.012, dial.size * (1.0 - 0.012)
    title, orientation = corners
    if heading is not None:
        orientation += f"\nheading {round(np.degrees(heading), 1) % 360.0:05.1f}\N{DEGREE SIGN}"
    reach = f"range {range_text(range_max, unit)}\nrings {range_text(step, unit)}"
    draw.text((near, near), title, fill=SCALE, font=dial.font, anchor="la")
    draw.multiline_text((near, far), orientation, fill=SCALE, font=dial.font, anchor="ld")
    draw.multiline_text((far, far), reach, fill=SCALE, font=dial.font, anchor="rd", align="right")
