"""Responses of a hull: limits of theory, the published expressions written out as they are printed, scaling."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.constants import GRAVITY
from radar_service.numerics.types import Floats
from radar_service.world.seaway_motion import HullForm, Response, response

COASTER = HullForm(75.0, 12.5, 5.0, 0.7, 0.8, 8.9, 0.1)
FREQUENCY = np.array([0.16, *np.linspace(0.3, 2.5, 45)])  # rad/s; the first is of waves 24 hulls long


def at(form: HullForm, frequency: Floats, course: float, speed: float = 0.0) -> Response:
    """The response to waves that travel `course` degrees off the bow's direction, to starboard: 180 is a head sea."""
    k, off = frequency**2 / GRAVITY, np.deg2rad(course)
    return response(form, frequency, k * np.cos(off), k * np.sin(off), frequency - speed * k * np.cos(off))


@pytest.mark.parametrize("course", [0.0, 50.0, 90.0, 180.0, 250.0])
def test_a_ship_follows_long_waves(course: float) -> None:
    """Heave over the wave 1, pitch and roll over the slopes 1: waves of 40 km, whose k T is 7e-4, and k L 0.01."""
    frequency = np.array([0.04])
    k, off = frequency**2 / GRAVITY, np.deg2rad(course)
    roll, pitch, heave = at(COASTER, frequency, course)
    assert heave == pytest.approx(1.0, abs=2e-3)
    assert pitch / k == pytest.approx(1j * np.cos(off), abs=2e-3), "bow up where the sea rises ahead"
    assert roll / k == pytest.approx(-1j * np.sin(off), abs=2e-2), "starboard down where it falls; damping lags by 1 %"


@pytest.mark.parametrize("speed", [0.0, 6.0])
@pytest.mark.parametrize("course", [0.0, 30.0, 135.0, 180.0])
def test_heave_and_pitch_are_the_published_ones(course: float, speed: float) -> None:
    """Amplitudes of Jensen, Mansour and Olsen 2004, written out with their alpha, A, f, kappa, F, G and eta."""
    form, g = COASTER, GRAVITY
    breadth, draught, length = form.breadth * form.block, form.draught, form.length
    _, pitch, heave = at(form, FREQUENCY, course, speed)
    for n, omega in enumerate(FREQUENCY.tolist()):
        k = omega**2 / g
        froude = speed / np.sqrt(g * length)
        alpha = 1.0 - froude * np.sqrt(k * length) * np.cos(np.deg2rad(course))
        k_e = abs(k * np.cos(np.deg2rad(course)))
        a = 2.0 * np.sin(k * breadth * alpha**2 / 2.0) * np.exp(-k * draught * alpha**2)
        f = np.sqrt((1.0 - k * draught) ** 2 + (a**2 / (k * breadth * alpha**3)) ** 2)
        kappa = np.exp(-k * draught)
        big_f = kappa * f * 2.0 / (k_e * length) * np.sin(k_e * length / 2.0)
        big_g = kappa * f * 24.0 / ((k_e * length) ** 2 * length)
        big_g *= np.sin(k_e * length / 2.0) - k_e * length / 2.0 * np.cos(k_e * length / 2.0)
        eta = 1.0 / np.sqrt((1.0 - 2.0 * k * draught * alpha**2) ** 2 + (a**2 / (k * breadth * alpha**2)) ** 2)
        assert abs(heave[n]) == pytest.approx(abs(eta * big_f), rel=1e-9)
        assert abs(pitch[n]) == pytest.approx(abs(eta * big_g), rel=1e-9, abs=1e-15)


def test_roll_is_a_resonance() -> None:
    """At its natural period a hull rolls 1 / (2 damping) times the effective slope, a quarter of a period later; far above it
    it does not. Of waves as long as three beams the effective slope is known: 3 (sin x - x cos x) / x^3 at x = 0.8 pi / 3."""
    natural = np.array([2.0 * np.pi / COASTER.roll_period])
    k = natural**2 / GRAVITY
    x = 0.8 * COASTER.breadth * k / 2.0
    slope = k * np.exp(-k * COASTER.draught) * 3.0 * (np.sin(x) - x * np.cos(x)) / x**3
    assert at(COASTER, natural, 90.0).roll / slope == pytest.approx(1.0 / (2.0 * 0.1), rel=1e-9)
    assert abs(at(COASTER, 3.0 * natural, 90.0).roll[0]) < 0.01 * 9.0 * k[0]
    assert not at(COASTER, natural, 0.0).roll[0] and at(COASTER, natural, 90.0).pitch[0] == pytest.approx(0.0, abs=1e-15)


def test_responses_scale_by_froude() -> None:
    """A ship 3 times as large in waves 3 times as long answers by the same angles a wave slope, and the same heave a height."""
    size = 3.0
    large = HullForm(225.0, 37.5, 15.0, 0.7, 0.8, 8.9 * np.sqrt(size), 0.1)
    small, scaled = at(COASTER, FREQUENCY, 130.0, 5.0), at(large, FREQUENCY / np.sqrt(size), 130.0, 5.0 * np.sqrt(size))
    for one, other, factor in zip(small, scaled, (size, size, 1.0), strict=True):
        np.testing.assert_allclose(factor * other, one, rtol=1e-9, atol=1e-12)


def test_a_ship_that_overtakes_waves_lags_behind_them_too() -> None:
    """With exp(-i w t), a frequency below 0 is the conjugate motion: damping takes energy at either sign."""
    k = FREQUENCY**2 / GRAVITY
    met, overtaken = (response(COASTER, FREQUENCY, 0.6 * k, 0.8 * k, sign * 0.7 * FREQUENCY) for sign in (1.0, -1.0))
    np.testing.assert_allclose(overtaken.heave, np.conj(met.heave), rtol=1e-12)
    np.testing.assert_allclose(overtaken.roll, -np.conj(met.roll), rtol=1e-12)
    still = response(COASTER, FREQUENCY, k, 0.0 * k, 0.0 * FREQUENCY)
    assert np.isfinite(still.heave).all() and np.isfinite(still.pitch).all(), "at rest in a wave that it rides"


def test_a_planing_craft_has_a_largest_speed_for_its_response() -> None:
    assert COASTER.max_speed == pytest.approx(0.4 * np.sqrt(9.80665 * 75.0))
    assert replace(COASTER, length=8.0).max_speed < 4.0  # m/s
