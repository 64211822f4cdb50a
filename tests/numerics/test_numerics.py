"""The short modules of numerics, each under its name."""

import numpy as np
import pytest
from scipy import constants as codata
from scipy.integrate import quad

from radar_service.numerics import constants
from radar_service.numerics.gamma_law import clutter_level_factor, known_level_factor
from radar_service.numerics.kaiser_bessel import MIN_OVERSAMPLING, kernel_transform, shape_parameter
from radar_service.numerics.ragged import batches, spans


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
