"""Spokes accumulated, and polar turned into an image: against theory, and against a slow reference written out plainly."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.display.ppi import Interpolation, Ppi, Up, image_position, scan_convert

Floats = NDArray[np.float64]
TARGETS = ((30.0, 1200.0), (120.0, 2400.0), (250.0, 4000.0))  # bearing in degrees, range in metres


def polar_with_targets(azimuths: int, bins: int, step: float) -> NDArray[np.float32]:
    """Point targets as three bright blobs, wide enough that a bilinear picture of large pixels shows them too."""
    distance, azimuth = (np.arange(bins) + 0.5) * step, np.arange(azimuths) * 2 * np.pi / azimuths
    polar = np.zeros((azimuths, bins))
    for number, (bearing_deg, there) in enumerate(TARGETS):
        off = np.angle(np.exp(1j * (azimuth - math.radians(bearing_deg))))
        polar += (number + 1) * np.exp(-((off / 0.02) ** 2))[:, None] * np.exp(-(((distance - there) / 15.0) ** 2))
    return polar.astype(np.float32)


def slow_picture(
    polar: Floats, first: float, step: float, size: int, range_max: float, top: float, mode: Interpolation
) -> Floats:
    """The reference: one pixel at a time, by the definitions."""
    azimuths, bins = polar.shape
    pixel = 2 * range_max / size
    image = np.zeros((size, size))
    group = max(1, int(pixel / step)) if mode == "peak" else 1
    thin = np.array([[max(row[i : i + group]) for i in range(0, bins, group)] for row in polar])
    thin_first, thin_step, far = first + (group - 1) / 2 * step, group * step, first + (bins - 0.5) * step
    for i in range(size):
        for j in range(size):
            x, y = (j + 0.5) * pixel - range_max, range_max - (i + 0.5) * pixel
            distance = math.sqrt(x * x + y * y)
            if distance > range_max or distance > far or distance < first - step / 2:
                continue
            n = min(max((distance - thin_first) / thin_step, 0), thin.shape[1] - 1)
            k = ((math.atan2(x, y) + top) % (2 * math.pi)) / (2 * math.pi) * azimuths
            n0, k0 = math.floor(n), math.floor(k)
            n1 = min(n0 + 1, thin.shape[1] - 1)
            near = thin[k0 % azimuths]
            after = thin[(k0 + 1) % azimuths]
            one = near[n0] + (n - n0) * (near[n1] - near[n0])
            two = after[n0] + (n - n0) * (after[n1] - after[n0])
            image[i, j] = one + (k - k0) * (two - one)
    if mode == "peak":
        for k in range(azimuths):
            for n in range(bins):
                there, angle = first + n * step, 2 * math.pi * k / azimuths - top
                if 0 <= there <= range_max:
                    i = math.floor((range_max - there * math.cos(angle)) / pixel)
                    j = math.floor((range_max + there * math.sin(angle)) / pixel)
                    if 0 <= i < size and 0 <= j < size:
                        image[i, j] = max(image[i, j], polar[k, n])
    return image


@pytest.mark.parametrize("mode", ["bilinear", "peak"])
@pytest.mark.parametrize("heading_deg", [0.0, 70.0])
@pytest.mark.parametrize("head_up", [False, True])
def test_targets_stand_where_theory_puts_them(mode: Interpolation, heading_deg: float, head_up: bool) -> None:
    size, range_max, azimuths, step = 501, 5000.0, 720, 2.0
    polar = polar_with_targets(azimuths, 2500, step)
    up: Up = math.radians(heading_deg) if head_up else "north"
    image = scan_convert(polar, step / 2, step, size, range_max, up, mode)
    for bearing_deg, there in TARGETS:
        turned = math.radians(bearing_deg - (heading_deg if head_up else 0.0))
        row = (range_max - there * math.cos(turned)) / (2 * range_max) * size - 0.5
        column = (range_max + there * math.sin(turned)) / (2 * range_max) * size - 0.5
        i0, j0 = round(row) - 12, round(column) - 12
        patch = image[i0 : i0 + 25, j0 : j0 + 25]
        i, j = np.unravel_index(np.argmax(patch), patch.shape)
        # One pixel each way: the blob's peak falls between pixel centres (half), and between azimuths (a quarter degree
        # at 4000 m is 17 m, 0.9 pixels) or range cells (1 m).
        assert abs(i0 + i - row) <= 1.5 and abs(j0 + j - column) <= 1.5


@pytest.mark.parametrize("mode", ["bilinear", "peak"])
@pytest.mark.parametrize(
    ("azimuths", "bins", "first", "step", "size", "range_max", "top"),
    [
        (36, 40, 0.5, 1.0, 64, 40.3, 0.01),  # fine pixels, and no cell on the edge of one, where rounding would choose
        (36, 50, 0.5, 1.0, 21, 50.0, 1.1),  # pixels of nearly five cells, odd size: one looks at the antenna itself
        (7, 33, 0.0, 1.5, 18, 60.0, -0.4),  # first sample at zero range, as documented; range beyond the last cell
        (5, 9, 20.0, 2.0, 30, 30.0, 4.0),  # a window that opens at 19 m and is cut at 30
        (1, 1, 10.0, 20.0, 8, 20.0, 0.0),  # one cell
    ],
)
def test_scan_conversion_agrees_with_a_slow_reference(
    mode: Interpolation, azimuths: int, bins: int, first: float, step: float, size: int, range_max: float, top: float
) -> None:
    polar = np.random.default_rng(5).uniform(0.0, 100.0, (azimuths, bins)).astype(np.float32)
    image = scan_convert(polar, first, step, size, range_max, top, mode)
    reference = slow_picture(polar.astype(np.float64), first, step, size, range_max, top, mode)
    # float32 rounding of four weights and their sum: a few units in the last place of 100, 6e-8 relative each
    np.testing.assert_allclose(image, reference, rtol=0, atol=100 * 8 * 6e-8)


def test_bilinear_is_exact_for_what_is_linear_in_range_and_wraps_in_azimuth() -> None:
    azimuths, bins, step, size, range_max = 90, 100, 10.0, 300, 900.0
    distance = (np.arange(bins) + 0.5) * step
    image = scan_convert(np.tile(distance, (azimuths, 1)), step / 2, step, size, range_max)
    offset = (np.arange(size) + 0.5) * (2 * range_max / size) - range_max
    there = np.hypot(offset[:, None], offset)
    inside = (there <= range_max) & (there >= step / 2)
    np.testing.assert_allclose(image[inside], there[inside], rtol=1e-6)  # float32 rounding
    only_last = np.zeros((azimuths, bins))
    only_last[-1] = 1.0  # looks along 356 degrees: its share must reach up to north from the west
    row, column = image_position(600.0, math.radians(358.0), size, range_max)
    share = scan_convert(only_last, step / 2, step, size, range_max)[round(float(row)), round(float(column))]
    # half way between the last and the first azimuth; the pixel's centre is off by at most 4.2 m of the 42 m in between
    assert share == pytest.approx(0.5, abs=0.1)


def test_peak_loses_no_cell_where_bilinear_loses_most() -> None:
    azimuths, bins, step, size, range_max = 720, 2500, 2.0, 200, 5000.0
    random = np.random.default_rng(11)
    rows, columns = random.integers(0, azimuths, 50), random.integers(5, bins, 50)
    result = {"bilinear": 0, "peak": 0}
    polar = np.zeros((azimuths, bins), dtype=np.uint8)
    polar[rows, columns] = 200
    for mode in ("bilinear", "peak"):
        image = scan_convert(polar, step / 2, step, size, range_max, interpolation=mode)
        positions = image_position((columns + 0.5) * step, rows * 2 * np.pi / azimuths, size, range_max)
        i, j = (np.clip(np.rint(p).astype(int), 0, size - 1) for p in positions)
        result[mode] = int((image[i, j] >= 199.99).sum())
    assert result["peak"] == 50
    assert result["bilinear"] < 10  # a pixel of 50 m looks at 2 m of range


def test_image_position_puts_north_in_row_zero_and_east_at_the_right() -> None:
    bearings = np.radians([0.0, 90.0, 180.0, 270.0])
    row, column = image_position(100.0, bearings, 200, 100.0)
    np.testing.assert_allclose(row, [-0.5, 99.5, 199.5, 99.5], atol=1e-12)  # edges lie half a pixel beyond the centres
    np.testing.assert_allclose(column, [99.5, 199.5, 99.5, -0.5], atol=1e-12)
    row, column = image_position(100.0, bearings, 200, 100.0, up=math.radians(90.0))
    np.testing.assert_allclose(row, [99.5, -0.5, 99.5, 199.5], atol=1e-12)


def test_conversion_refuses_what_it_cannot_show() -> None:
    polar = np.zeros((4, 4))
    with pytest.raises(ValueError, match="complex128"):
        scan_convert(polar.astype(np.complex128), 0.5, 1.0, 10, 4.0)
    with pytest.raises(ValueError, match=r"\(0, 4\)"):
        scan_convert(polar[:0], 0.5, 1.0, 10, 4.0)
    for size, range_max, step in ((0, 4.0, 1.0), (10, 0.0, 1.0), (10, float("nan"), 1.0), (10, 4.0, -1.0)):
        with pytest.raises(ValueError, match="above 0"):
            scan_convert(polar, 0.5, step, size, range_max)


def test_ppi_keeps_the_newest_spoke_of_each_row_whatever_the_order() -> None:
    spokes = np.arange(1, 25, dtype=np.uint8)[:, None] * np.ones(5, dtype=np.uint8)  # 24 spokes: three turns of eight rows
    straight, shuffled = Ppi(8, 5, 0.5, 1.0), Ppi(8, 5, 0.5, 1.0)
    numbers = np.arange(24)
    assert straight.add(numbers % 8, spokes, numbers).all()
    order = np.random.default_rng(3).permutation(np.concatenate([numbers, numbers]))
    for part in np.split(order, 6):
        shuffled.add(part % 8, spokes[part], part)
    np.testing.assert_array_equal(straight.polar[:, 0], np.arange(17, 25))
    np.testing.assert_array_equal(shuffled.polar, straight.polar)
    np.testing.assert_array_equal(shuffled.number, straight.number)


def test_ppi_says_what_is_news_what_is_missing_and_how_old() -> None:
    ppi = Ppi(4, 3, 0.5, 1.0)
    ones = np.ones((2, 3), dtype=np.uint8)
    assert not ppi.filled.any() and list(ppi.age) == [-1, -1, -1, -1]
    assert list(ppi.add([3, 0], ones, [3, 4])) == [True, True]
    assert list(ppi.add([0, 2], 7 * ones, [4, 6])) == [False, True]  # the first is a repeat
    assert list(ppi.filled) == [True, False, True, True]
    assert list(ppi.age) == [2, -1, 0, 3]
    assert ppi.polar[0, 0] == 1 and ppi.polar[2, 0] == 7
    assert ppi.range_end == 3.0


def test_ppi_refuses_spokes_that_do_not_fit() -> None:
    ppi = Ppi(4, 3, 0.5, 1.0)
    with pytest.raises(ValueError, match="rows 0 to 3"):
        ppi.add([4], np.ones((1, 3), np.uint8), [0])
    with pytest.raises(ValueError, match="rows 0 to 3"):
        ppi.add([-1], np.ones((1, 3), np.uint8), [0])
    with pytest.raises(ValueError, match=r"\(1, 2\)"):
        ppi.add([1], np.ones((1, 2), np.uint8), [0])
    with pytest.raises(ValueError, match="empty"):
        Ppi(0, 3, 0.5, 1.0)
    with pytest.raises(ValueError, match="above 0"):
        Ppi(4, 3, 0.5, 0.0)
    assert not ppi.filled.any()
