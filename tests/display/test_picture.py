"""The PNG: brightness in dB, targets and heading line where they belong."""

import math
from io import BytesIO

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from radar_service.display.palettes import colour_map
from radar_service.display.picture import (
    SEA,
    UNSEEN,
    Drawing,
    picture_from_power,
    render_png,
)
from radar_service.display.units import Unit

TARGETS = ((30.0, 1300.0), (120.0, 2300.0), (250.0, 3700.0))  # bearing in degrees, range in metres; none on a ring of 1000 m


def pixels(png: bytes) -> NDArray[np.uint8]:
    image = Image.open(BytesIO(png))
    assert image.format == "PNG" and image.mode == "RGB"
    return np.asarray(image)


def test_brightness_is_decibels_below_the_strongest() -> None:
    power = np.array([[2e-9, 2e-9 * 10**-3.0, 2e-9 * 10**-6.0, 0.0]])
    # 0 dB, -30 dB: half of 255 (127.5 rounds either way), -60 dB, nothing
    assert picture_from_power(power, 60.0)[0].tolist() in ([255, 127, 0, 0], [255, 128, 0, 0])
    assert picture_from_power(2.5 * power, 50.0).tolist() == picture_from_power(power, 50.0).tolist()
    assert not picture_from_power(np.zeros((3, 4))).any()


def test_power_that_is_none_is_refused() -> None:
    for bad in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="negative or non-finite"):
            picture_from_power(np.array([[1.0, bad]]))
    with pytest.raises(ValueError, match="0 dB"):
        picture_from_power(np.ones((1, 1)), 0.0)


@pytest.mark.parametrize("heading_deg", [0.0, 70.0])
@pytest.mark.parametrize("head_up", [False, True])
def test_targets_and_heading_line_stand_where_theory_puts_them(heading_deg: float, head_up: bool) -> None:
    azimuths, bins, step, size = 720, 2500, 2.0, 700
    picture = np.zeros((azimuths, bins), dtype=np.uint8)
    for bearing_deg, there in TARGETS:
        row, column = round(bearing_deg * 2), round(there / step - 0.5)
        picture[row - 2 : row + 3, column - 3 : column + 4] = 255
    png = render_png(picture, step / 2, step, size=size, heading=math.radians(heading_deg), head_up=head_up, unit="m")
    image = pixels(png).astype(int)
    assert image.shape == (size, size, 3)
    radius = (size - 2 * round(0.052 * size)) / 2
    turned = math.radians(heading_deg) if head_up else 0.0
    echo = np.abs(image - colour_map()[255]).sum(axis=2) < 60
    for bearing_deg, there in TARGETS:
        angle, far = math.radians(bearing_deg) - turned, there / (bins * step) * radius
        x, y = size / 2 + far * math.sin(angle) - 0.5, size / 2 - far * math.cos(angle) - 0.5
        i0, j0 = round(y) - 10, round(x) - 10
        lit = np.argwhere(echo[i0 : i0 + 21, j0 : j0 + 21]) + (i0, j0)
        # The patch is symmetric but for its lit pixels being whole ones: its middle is good to a pixel.
        assert np.abs(lit.mean(axis=0) - (y, x)).max() < 1.0
        echo[i0 : i0 + 21, j0 : j0 + 21] = False
    assert not echo.any()  # nothing shines anywhere else: no mirror image, no second copy
    angle = math.radians(heading_deg) - turned
    on_line = [
        (size / 2 - s * radius * math.cos(angle), size / 2 + s * radius * math.sin(angle)) for s in (0.31, 0.53, 0.77)
    ]
    assert all(image[int(i - 1) : int(i + 2), int(j - 1) : int(j + 2)].min(axis=2).max() > 50 for i, j in on_line)


def test_a_lone_cell_is_not_lost_in_a_small_picture() -> None:
    picture = np.zeros((720, 2500), dtype=np.uint8)
    picture[101, 1234] = 255
    bright = pixels(render_png(picture, 1.0, 2.0, size=200)).astype(int)
    dim = pixels(render_png(picture, 1.0, 2.0, size=200, interpolation="bilinear")).astype(int)
    shine = np.abs(bright - colour_map()[255]).sum(axis=2)
    assert (shine < 30).sum() == 1
    assert (np.abs(dim - colour_map()[255]).sum(axis=2) < 30).sum() == 0


def test_rows_without_a_spoke_are_grey_and_the_sea_is_dark() -> None:
    filled = np.ones(360, dtype=np.bool_)
    filled[80:101] = False  # about east
    image = pixels(render_png(np.zeros((360, 100), np.uint8), 0.5, 1.0, size=300, filled=filled))
    assert image[150 - 4, 150 + 90].tolist() == list(UNSEEN)
    assert image[150 - 4, 150 - 90].tolist() == list(SEA)
    assert image[2, 298].tolist() == image[20, 20].tolist() == [0, 0, 0]  # beyond the page's margin, and beyond the rim


def test_without_a_heading_there_is_no_heading_line() -> None:
    empty = np.zeros((360, 100), np.uint8)
    one, other = (pixels(render_png(empty, 0.5, 1.0, size=300, heading=heading)) for heading in (None, math.nan))
    np.testing.assert_array_equal(one, other)
    assert (one != pixels(render_png(empty, 0.5, 1.0, size=300, heading=0.3))).any()
    with pytest.raises(ValueError, match="head_up: needs a heading"):
        render_png(empty, 0.5, 1.0, size=300, heading=math.nan, head_up=True)


def test_range_max_scales_the_picture() -> None:
    picture = np.zeros((360, 100), dtype=np.uint8)
    picture[:, 40:44] = 255  # a ring about 42 m
    image = pixels(render_png(picture, 0.5, 1.0, size=400, range_max=50.0)).astype(int)
    inside = image[200 + 31, 26:374, 1]  # green, of a row within the dial
    lit = 26 + np.flatnonzero(inside > colour_map()[128, 1])  # half way down from 255 to 0: at the edge, 44 m
    assert abs((lit.min() + lit.max()) / 2 - 199.5) < 1.0  # symmetric, to a pixel
    half = (lit.max() - lit.min() + 1) / 2
    # 358 pixels are 100 m, the row lies 31.5 pixels below the middle; the edge is known to a pixel
    assert math.hypot(half, 31.5) == pytest.approx(44.0 / 100.0 * 358, abs=1.0)


def test_pictures_that_cannot_be_drawn_are_refused() -> None:
    picture = np.zeros((4, 4), dtype=np.uint8)
    with pytest.raises(ValueError, match="uint8"):
        render_png(picture.astype(np.float32), 0.5, 1.0)
    for size in (63, 4097):
        with pytest.raises(ValueError, match=f"size: {size}"):
            render_png(picture, 0.5, 1.0, size=size)
    with pytest.raises(ValueError, match="head_up"):
        render_png(picture, 0.5, 1.0, head_up=True)


@pytest.mark.parametrize(("unit", "step"), [(None, 926.0), ("nm", 926.0), ("m", 1000.0)])
def test_rings_are_drawn_in_the_unit_and_by_default_in_nautical_miles(unit: Unit | None, step: float) -> None:
    """A picture of 5 km, 600 pixels: along south, where no label stands, rings are brighter than the sea."""
    drawing = Drawing(unit=unit) if unit else Drawing()
    image = pixels(render_png(np.zeros((360, 100), np.uint8), 25.0, 50.0, size=600, **drawing)).astype(int)
    radius = (600 - 2 * round(0.052 * 600)) / 2
    lit = np.flatnonzero(image[300:, 299].sum(axis=1) > 2 * sum(SEA)) + 0.5
    rings = np.array([far for far in lit if far < radius - 3]) * 5000.0 / radius
    assert {round(far / step) for far in rings} == set(range(1, int(np.ceil(5000.0 / step))))
    assert (
        np.abs(rings - np.rint(rings / step) * step).max() < 1.5 * 5000.0 / radius
    )  # a line of two pixels, one of them half
