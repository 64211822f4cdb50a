"""The short modules of numerics, each under its name."""

from typing import get_args

import numpy as np
import pytest
import scipy.stats
from scipy import constants as codata
from scipy.integrate import quad

from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.numerics import constants, types
from radar_service.numerics.gamma_law import clutter_level_factor, known_level_factor
from radar_service.numerics.kaiser_bessel import MIN_OVERSAMPLING, kernel_transform, shape_parameter
from radar_service.numerics.ragged import batches, spans
from radar_service.numerics.random import generator, name_key, normals
from radar_service.records.fidelity import PRESETS
from radar_service.records.spokes import square_law
from tests.scenes import point, scene


# constants: constants against CODATA, as scipy has it, and against their definitions.
def test_constants_are_those_of_codata_and_of_the_mile() -> None:
    """All exact by definition."""
    assert (constants.SPEED_OF_LIGHT, constants.BOLTZMANN) == (codata.c, codata.k)
    assert (constants.NAUTICAL_MILE, constants.KNOT) == (codata.nautical_mile, codata.knot)


def test_noise_density_at_the_reference_temperature() -> None:
    """k T0 is -204 dBW/Hz (-203.98; IEEE Std 686 takes 290 K for this round number): half the last digit."""
    assert constants.BOLTZMANN * constants.REFERENCE_TEMPERATURE == pytest.approx(10**-20.398, rel=0.0012)


def test_the_earth_has_its_mean_radius() -> None:
    """A degree of a great circle is 60 nautical miles to 0.1 %, as the mile was first defined; WGS 84: (2 a + b) / 3."""
    assert constants.EARTH_RADIUS * codata.degree == pytest.approx(60 * constants.NAUTICAL_MILE, rel=1e-3)
    assert constants.EARTH_RADIUS == pytest.approx(
        (2 * 6_378_137.0 + 6_356_752.3) / 3, abs=10.0
    )  # rounded to a km, less 9 m


# gamma_law: factors on known levels of averaged power, against draws of all pulses.
def test_of_one_pulse_the_law_is_exponential() -> None:
    assert known_level_factor(1e-4) == clutter_level_factor(1e-4, 3.0, 1) == -np.log(1e-4)


@pytest.mark.parametrize("clutter", [0.0, 0.1, 1.0, 30.0])
@pytest.mark.parametrize("pulses", [2, 10])
def test_noise_and_clutter_exceed_their_factor_as_rarely_as_asked(clutter: float, pulses: int) -> None:
    """200,000 draws of a speckle that all pulses share and of noise that none share; four standard errors of 2 %."""
    rng = np.random.default_rng(8)
    shared, noise = (rng.standard_normal((2, n, 200_000)) / np.sqrt(2.0) for n in (1, pulses))
    power = ((np.sqrt(clutter) * shared + noise) ** 2).sum(axis=0).mean(axis=0) / (1.0 + clutter)
    assert (power > clutter_level_factor(1e-2, clutter, pulses)).mean() == pytest.approx(1e-2, rel=0.09)


# kaiser_bessel: the Kaiser-Bessel kernel: its transform against the integral of its definition.
@pytest.mark.parametrize(("width", "oversampling"), [(4, 1.5), (6, 2.0), (8, 1.0)])
def test_the_transform_is_the_integral_of_the_kernel(width: int, oversampling: float) -> None:
    """Quadrature is good to 1e-8 of the peak."""
    beta = shape_parameter(width, oversampling)
    for frequency in (0.0, 0.3, 0.9, 2.2):

        def integrand(x: float, frequency: float = frequency) -> float:
            return float(
                np.i0(beta * np.sqrt(1.0 - (2.0 * x / width) ** 2)) / np.i0(beta) * np.cos(2 * np.pi * frequency * x)
            )

        expected = 2.0 * quad(integrand, 0.0, width / 2.0, limit=200)[0]
        assert kernel_transform(np.array([frequency]), width, beta)[0] == pytest.approx(expected, abs=1e-8)


def test_the_shape_parameter_is_that_of_beatty() -> None:
    """pi sqrt(W^2 / s^2 (s - 1/2)^2 - 0.8) for W = 6, s = 2 by hand; a grid without oversampling counts as oversampled 1.1."""
    assert shape_parameter(6, 2.0) == pytest.approx(np.pi * np.sqrt(4.5**2 - 0.8))
    assert shape_parameter(6, 1.0) == shape_parameter(6, MIN_OVERSAMPLING)


# ragged: rows of unequal lengths, against loops over them.
@pytest.mark.parametrize("rows", [0, 1, 50])
def test_spans_are_the_numbers_of_each_row(rows: int) -> None:
    """Some rows are empty, and some end before they begin."""
    rng = np.random.default_rng(rows)
    first = rng.integers(-5, 20, rows)
    last = first + rng.integers(-2, 6, rows)
    expected = [(n, k) for n, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)) for k in range(a, b)]
    assert list(zip(*(part.tolist() for part in spans(first, last)), strict=True)) == expected


def test_batches_hold_all_rows_once_and_no_more_than_the_limit() -> None:
    count = np.random.default_rng(1).integers(0, 40, 100)
    count[7] = 500
    parts = list(batches(count, 100))
    assert [n for part in parts for n in range(part.start, part.stop)] == list(range(100))
    assert all(count[part].sum() <= 100 or part.stop == part.start + 1 for part in parts)
    assert all(count[a.start : b.start + 1].sum() > 100 for a, b in zip(parts[:-1], parts[1:], strict=True))
    assert not list(batches(np.zeros(0, dtype=np.int64), 100))
    assert [part.stop for part in batches(np.zeros(3, dtype=np.int64), 100)] == [3]


# types: array types: what the engine computes has the type that its signatures name.
def element(alias: object) -> type:
    """The element type of an array type."""
    (element_type,) = get_args(get_args(alias)[1])
    return element_type


def test_the_engine_returns_what_it_says() -> None:
    made = scene(
        [point("a", 0, 300), point("b", 100, 300, speed_kn=10)],
        radar={"azimuths": 36, "range_max_m": 500, "beamwidth_deg": 12},
    )
    prepared = prepare(made, PRESETS["balanced"], 1)
    azimuths = tile_azimuths(prepared, 0, 0)
    field, echoes = profiles(prepared, azimuths), prepared.moving.echoes(azimuths)
    assert field.dtype == echoes.amplitude.dtype == element(types.Profiles)
    assert square_law(field).dtype == echoes.range_migration.dtype == element(types.Singles)
    assert echoes.range.dtype == azimuths.time.dtype == element(types.Floats)
    assert azimuths.number.dtype == prepared.resting.body.dtype == element(types.Indices)
    assert prepared.resting.echoes.amplitude.dtype == element(types.Complexes)
    assert prepared.line_of_sight.present(0.0).dtype == element(types.Flags)


# random: streams that depend on seed and key alone, and normal numbers from a table.
def draws(seed: int, *key: int) -> bytes:
    return generator(seed, *key).integers(0, 2**63, 4).tobytes()


def test_the_same_key_gives_the_same_stream_whatever_was_drawn_in_between() -> None:
    first = draws(3, 1, 2)
    generator(3, 1, 3).normal(size=100)
    assert draws(3, 1, 2) == first


def test_keys_that_differ_in_any_way_give_different_streams() -> None:
    # the last pairs are those that numpy's own zero padding and 32-bit words would merge
    keys = [(0,), (1,), (1, 0), (0, 1), (1, 0, 0), (1, 2), (2, 1), (12,), (2**32,), (0, 2**32), (2**32, 0), (0, 0, 1), ()]
    streams = {draws(7, *key) for key in keys} | {draws(8, *key) for key in keys}
    assert len(streams) == 2 * len(keys)


@pytest.mark.parametrize("key", [(-1,), (2**64,), (0, -5)])
def test_a_key_out_of_bounds_is_refused_with_its_index(key: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=rf"key\[{len(key) - 1}\]: {key[-1]} is not allowed; a whole number from 0"):
        generator(0, *key)


def test_streams_of_neighbouring_keys_are_uncorrelated() -> None:
    many = np.array([generator(0, scan, azimuth).normal(size=1000) for scan in range(10) for azimuth in range(10)])
    correlation = np.corrcoef(many)[np.triu_indices(100, 1)]
    assert np.abs(correlation).max() < 5.2 / np.sqrt(1000)  # 5.2 sigma: 4950 pairs, chance 1e-3 in all


def test_normal_numbers_are_normal() -> None:
    """65,536 slices are finer than what 400 000 draws resolve: Kolmogorov-Smirnov at 1e-4; mean and variance to 5 sigma."""
    numbers = normals(generator(1, 2), 400, 1000)
    assert numbers.shape == (400, 1000) and numbers.dtype == np.float32
    values = numbers.ravel().astype(float)
    assert scipy.stats.kstest(values, "norm").pvalue > 1e-4
    assert abs(values.mean()) < 5 / np.sqrt(values.size) and abs(values.var() - 1) < 5 * np.sqrt(2 / values.size)
    assert np.abs(np.corrcoef(values[:-1], values[1:])[0, 1]) < 5 / np.sqrt(values.size)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (2, 8)])
def test_any_count_of_normal_numbers_can_be_drawn(shape: tuple[int, int]) -> None:
    """Four come from each 64-bit word; the rest of the last word is dropped."""
    numbers = normals(generator(0), *shape)
    assert numbers.shape == shape and np.isfinite(numbers).all()
    np.testing.assert_array_equal(numbers.ravel(), normals(generator(0), 1, 40)[0, : numbers.size])


def test_names_make_keys_that_stay_the_same() -> None:
    """A stored value, so that a scene has the same luck in each version and on each machine; made when names became keys."""
    assert name_key("harbour", "pilot boat") == 9895391009513380443
    keys = {name_key(*names) for names in (("ab", ""), ("a", "b"), ("", "ab"), ("ab",), ("b", "a"), ("\u00e9", ""))}
    assert len(keys) == 6 and all(0 <= key < 2**64 for key in keys)
