"""Rows of Gaussian texture: on the map near by, independent far out, drifting with the waves, the same in any order."""

from typing import Any

import numpy as np
import pytest
import scipy.stats
from numpy.typing import NDArray

from radar_service.stages.clutter.texture import TextureLaw
from radar_service.stages.clutter.texture_rows import (
    CHUNK,
    IndependentRows,
    PeriodicTexture,
    TextureGrid,
    TextureLines,
    TextureRows,
    outward_units,
)

ROWS, STEP, LIFETIME = 64, 2.0, 4.0
ALONE = np.ones(1)  # overlap of a beam that covers one row


def at_anchor(time: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros((len(time), 2))


def rows(
    waves: Any = (0.0, 0.0), antenna: Any = at_anchor, columns: int = 2000, seed: int = 2, **changes: Any
) -> TextureRows:
    """Texture of 20 m along north and south and 10 m across; a revolution each 2 s, rows 5.6 degrees apart."""
    law = TextureLaw(20.0, 10.0, 0.0, changes.get("cell", 0.0))
    distance = (np.arange(columns, dtype=np.float64) + 0.5) * STEP
    grid = TextureGrid(ROWS, 2.0, STEP, distance, LIFETIME, np.array(waves, dtype=np.float64), antenna)
    return TextureRows(law, grid, ALONE, seed)


def correlation(a: NDArray[Any], b: NDArray[Any]) -> float:
    return float(np.mean(a * b) / np.sqrt(np.mean(a * a) * np.mean(b * b)))


@pytest.mark.parametrize("cell", [0.0, 9.0])
def test_unit_power_at_every_range_and_the_laws_length_along_it(cell: float) -> None:
    """Far out 1/e at the beam-averaged length with the pulse's, north and east; power 1 near by and far. 5 sigma."""
    made = rows(cell=cell, columns=4000)
    drawn = np.stack([made.make(scan, 0, ROWS) for scan in range(0, 120, 6)]).astype(np.float64)
    for part in (slice(0, 100), slice(100, 250), slice(250, 4000)):
        patches = 20 * ROWS * (part.stop - part.start) * STEP / 40 / (4 if part.start == 0 else 1)
        assert np.mean(drawn[..., part] ** 2) == pytest.approx(1.0, abs=5 * np.sqrt(2 / patches) + 0.02)
    for row, length in ((0, 20.0), (16, 10.0), (32, 20.0)):
        lag = round(float(np.hypot(length, cell)) / STEP)
        far = drawn[:, row, 300:]
        expected = np.exp(-((lag * STEP) ** 2) / (length**2 + cell**2))
        assert np.mean(far[:, lag:] * far[:, :-lag]) == pytest.approx(expected, abs=5 / np.sqrt(20 * 7400 / 60))


def test_a_long_pulse_reaches_across_the_antenna() -> None:
    """1 m north and south of it, a second apart: by both laws 0.99 cos(pi / 8), 0.915, less 3 sigma of 20 draws (Fisher's z)."""
    made = rows(cell=30.0, columns=20)
    drawn = np.stack([made.make(scan, 0, ROWS) for scan in range(0, 120, 6)])
    assert correlation(drawn[:, 0, 0], drawn[:, 32, 0]) > np.tanh(np.arctanh(0.915) - 3.0 / np.sqrt(17.0))


def test_rows_near_by_sample_one_map_and_far_rows_are_independent() -> None:
    """At 40 m rows lie 4 m apart: exp(-(4/10)^2) looking north, exp(-(4/20)^2) looking east. At 500 m and more they lie 50 m
    apart. 5 sigma of the patches."""
    made = rows(columns=450)
    drawn = np.stack([made.make(scan, 0, ROWS) for scan in range(0, 1200, 6)]).astype(np.float64)
    apart = 2 * np.pi / ROWS * 41.0
    for row, length in ((0, 10.0), (16, 20.0)):
        pair = correlation(drawn[:, row, 20], drawn[:, row + 1, 20])
        assert pair == pytest.approx(np.exp(-((apart / length) ** 2)), abs=5 * 0.3 / np.sqrt(200))
    assert abs(correlation(drawn[:, :-1, 250:], drawn[:, 1:, 250:])) < 5 / np.sqrt(200 * 63 * 10)


@pytest.mark.parametrize("part", [slice(0, 90), slice(300, 2000)], ids=["near", "far"])
def test_texture_lives_for_its_lifetime_and_no_longer(part: slice) -> None:
    """Two instants share the fields of the multiples of the lifetime on either side: the correlation is the sum of the
    products of their cosine and sine weights. Rows pass at scan x 2 s + row / 64 x 2 s; lifetime 4 s. 5 sigma."""
    made = rows()
    patches = 64 * 90 * 4 / 200 / 2 if part.start == 0 else 64 * 3400 / 40

    def weights(time: NDArray[np.float64]) -> NDArray[np.float64]:
        share, k = np.pi / 2 * (time / LIFETIME % 1), (time // LIFETIME).astype(int)
        result = np.zeros((len(time), 6))
        result[np.arange(len(time)), k], result[np.arange(len(time)), k + 1] = np.cos(share), np.sin(share)
        return result

    passes = np.arange(ROWS) / 32
    drawn = [made.make(scan, 0, ROWS)[:, part].astype(np.float64) for scan in range(6)]
    for later in range(6):
        expected = np.mean(np.sum(weights(passes) * weights(passes + 2 * later), axis=1))
        assert np.mean(drawn[0] * drawn[later]) == pytest.approx(expected, abs=5 / np.sqrt(patches))


SLOW = [((3.0, 4.0), (0.0, 0.0)), ((0.0, 0.0), (-3.0, -4.0)), ((5.0, -2.0), (2.0, -6.0))]


@pytest.mark.parametrize(
    ("column", "waves", "ship"),
    [*((column, *each) for column in (40, 300, 1500) for each in SLOW), (300, (30.0, -10.0), (0.0, 0.0))],
)
def test_texture_moves_with_the_waves_and_own_ship_leaves_it(
    column: int, waves: tuple[float, float], ship: tuple[float, float]
) -> None:
    """Waves of 5 m/s toward (3, 4) over ground, or the ship going the other way: a point of the sea that is 10 m farther on
    after 2 s has the value it had, up to its age. At 32 m/s rows far out move by a row. Found by the column outward and the
    row clockwise."""

    def antenna(time: NDArray[np.float64]) -> NDArray[np.float64]:
        return time[:, None] * np.array(ship)

    made = rows(waves, antenna)
    drawn = [np.concatenate([made.make(scan, 0, ROWS)] * 2).astype(np.float64) for scan in (600, 601)]
    toward = 2.0 * (np.array(waves) - np.array(ship))
    outward = outward_units(ROWS)
    half = 20 if column < 100 else 150
    matches, others = [], []
    for row in range(ROWS):
        out = round(float(toward @ outward[row]) / STEP)
        clockwise = toward[0] * outward[row, 1] - toward[1] * outward[row, 0]
        over = round(clockwise / ((column + 0.5) * STEP) * ROWS / (2 * np.pi))
        before = drawn[0][row, column - half // 2 : column + half // 2]
        after = drawn[1][(row + over) % ROWS]
        matches.append(np.mean(before * after[column - half // 2 + out : column + half // 2 + out]))
        others.append(np.mean(before * after[column - half // 2 + out + 20 : column + half // 2 + out + 20]))
    share = np.mean(
        [np.cos(b) * np.cos(b + np.pi / 4) + np.sin(b) * np.sin(b + np.pi / 4) for b in np.pi / 8 * np.arange(2)]
    )
    assert np.mean(matches) > 0.75 * share  # the shift is rounded to rows and columns, and turns while the beam goes round
    assert abs(np.mean(others)) < 0.25


def test_drift_beyond_the_whole_range_stays_texture() -> None:
    drawn = rows((1e5, 2e5), columns=500).make(3, 0, ROWS)
    assert np.var(drawn) == pytest.approx(1.0, abs=5 * np.sqrt(2 / (64 * 25)))


def test_a_field_of_independent_rows_is_circular() -> None:
    """A run of columns may begin anywhere: one that begins before the first column goes on smoothly beyond its start."""
    distance = (np.arange(200, dtype=np.float64) + 0.5) * STEP
    grid = TextureGrid(ROWS, 2.0, STEP, distance, LIFETIME, np.zeros(2), at_anchor)
    fields = IndependentRows(TextureLaw(20.0, 10.0, 0.0, 0.0), grid, seed=2)

    def begun(column: int) -> NDArray[Any]:
        moved, outward = np.zeros((ROWS, 2)), outward_units(ROWS)
        number, share = np.full(ROWS, 3), np.ones(ROWS, dtype=np.float32)
        return fields.rows(TextureLines(np.arange(ROWS), number, share, moved, moved + column * STEP * outward, outward), 0)

    half = CHUNK // 2  # so that columns that move together lie on both sides
    before, first = begun(-half), begun(0)
    np.testing.assert_array_equal(before[:, half:], first[:, :-half])
    assert correlation(before[:, half - 1], before[:, half]) > 0.8


def test_rows_do_not_depend_on_earlier_requests_nor_on_their_grouping() -> None:
    """Rows of scan 4, and of the start, where the beam covers rows before north (scan -1, taken as the start)."""
    whole = rows((1.0, 2.0), columns=300)
    for scan in range(-1, 4):
        whole.make(scan, 0, 16)
    np.testing.assert_array_equal(whole.make(4, 0, ROWS), rows((1.0, 2.0), columns=300).make(4, 0, ROWS))
    assert not np.array_equal(whole.make(4, 0, ROWS), rows((1.0, 2.0), columns=300, seed=3).make(4, 0, ROWS))


WIND = np.deg2rad(40.0)
TILE = PeriodicTexture(TextureLaw(24.0, 12.0, WIND, 0.0), seed=3)
LEVEL = 1e-4  # of the statistical test; the seed is fixed, so it either always passes or never


def values(start: NDArray[np.float64], bearing: float, distance: NDArray[np.float64], field: int = 0) -> NDArray[np.float64]:
    """Along lines from points (J, 2) at one bearing [rad]."""
    outward = np.tile([np.sin(bearing), np.cos(bearing)], (len(start), 1))
    return TILE.along_lines(np.full(len(start), field), start, outward, distance).astype(np.float64)


def starts(count: int, seed: int = 1) -> NDArray[np.float64]:
    return np.random.default_rng(seed).uniform(-1e5, 1e5, (count, 2))


def test_field_is_normal_with_unit_power() -> None:
    """Points far apart; Kolmogorov-Smirnov, and the variance to 5 sigma of 65,000 / 2 independent patches and of the points."""
    drawn = values(starts(4000), 0.0, np.zeros(1)).ravel()
    assert scipy.stats.kstest(drawn, "norm").pvalue > LEVEL
    drawn = values(starts(300_000), 0.0, np.zeros(1))
    assert np.mean(drawn**2) == pytest.approx(1.0, abs=5 * np.sqrt(2 / 30_000 + 2 / 300_000))


@pytest.mark.parametrize(
    ("off_wind_deg", "length"), [(0, 24.0), (90, 12.0), (45, np.sqrt(2 / (24**-2 + 12**-2))), (135, None)]
)
def test_correlation_is_gaussian_on_the_ellipse(off_wind_deg: float, length: float | None) -> None:
    """exp(-(r / length)^2) at every lag; 0.03: the nearest grid point (1 %) and 5 sigma of 30,000 patches. 135 is as 45."""
    length = length or float(np.sqrt(2 / (24**-2 + 12**-2)))
    lag = length * np.array([0.0, 0.5, 1.0, 1.5, 2.5])
    drawn = values(starts(60_000), WIND + np.deg2rad(off_wind_deg), lag)
    np.testing.assert_allclose(np.mean(drawn * drawn[:, :1], axis=0), np.exp(-((lag / length) ** 2)), atol=0.03)


def test_lines_that_cross_agree_where_they_cross() -> None:
    """A point of the map has one value, whatever line leads there, near or far from the start; but for the rounding of
    float32 to another grid point (5 % of points)."""
    point = starts(2000, 2) / 100
    bearing = np.random.default_rng(3).uniform(0, 2 * np.pi, 2000)
    outward = np.stack([np.sin(bearing), np.cos(bearing)], axis=1)
    far = TILE.along_lines(np.zeros(2000, dtype=np.int64), point - 3000.0 * outward, outward, np.array([3000.0]))
    assert np.mean(far != values(point, 0.0, np.zeros(1))) < 0.05


def test_fields_of_different_numbers_are_independent_at_a_point() -> None:
    """The number moves the tile by many lengths; 5 sigma of the points."""
    at = starts(20_000, 4)
    zero = values(at, 0.0, np.zeros(1), 0)
    for number in (1, 2, 3, 8, 57):
        assert abs(np.mean(zero * values(at, 0.0, np.zeros(1), number))) < 5 / np.sqrt(20_000)
