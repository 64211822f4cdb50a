"""Scattering centres have the field of the points that they replace."""

import numpy as np

from radar_service.scattering.physical_optics.scattering_centres import scattering_centres

K = 2 * np.pi / 0.03186


def test_centres_are_exact_for_the_antenna_and_last_for_a_while() -> None:
    """Same field at the antenna, but for -50 dB of the strongest centre; after a turn of the aspect by d each centre
    errs by k cell d (sqrt 3: diagonals)."""
    rng = np.random.default_rng(3)
    points = rng.uniform(-20, 20, size=(4000, 3))
    amplitude = rng.normal(size=4000) + 1j * rng.normal(size=4000)
    antenna = np.array([900.0, 700.0, 30.0])
    centre, merged = scattering_centres(points, amplitude, antenna, antenna, 2.0, K)
    assert len(centre) < 0.8 * len(points)

    def field(position: np.ndarray, value: np.ndarray, antenna: np.ndarray) -> complex:
        return complex(np.sum(value * np.exp(-2j * K * np.linalg.norm(position - antenna, axis=1))))

    dropped = 10 ** (-50 / 20) * np.abs(merged).max()
    assert abs(field(points, amplitude, antenna) - field(centre, merged, antenna)) < dropped
    turned = antenna + [0.02, -0.02, 0.0]
    error = abs(field(points, amplitude, turned) - field(centre, merged, turned))
    turn = np.hypot(0.02, 0.02) / np.linalg.norm(antenna)
    assert 0.0 < error < K * 4.0 * 1.5 * turn * np.abs(amplitude).sum()
    assert error < 0.05 * abs(field(points, amplitude, turned))


def test_nothing_stays_nothing() -> None:
    antenna = np.ones(3)
    centre, merged = scattering_centres(np.zeros((0, 3)), np.zeros(0, dtype=complex), antenna, antenna, 2.0, K)
    assert len(centre) == len(merged) == 0


def test_silent_points_make_no_nan() -> None:
    antenna = np.array([50.0, 0, 0])
    centre, merged = scattering_centres(np.ones((3, 3)), np.zeros(3, dtype=complex), antenna, antenna, 2.0, K)
    assert np.isfinite(centre).all() and (merged == 0).all()


def test_what_is_left_out_is_faint_even_together() -> None:
    """One strong point and a thousand faint ones that add up to just under -50 dB of it: gone; just over: only what is
    over stays."""
    points = np.arange(1001)[:, None] * np.array([0.0, 10.0, 0.0])
    antenna = np.array([1e5, 0.0, 0.0])
    for total, left in ((0.99, 1), (1.5, 335)):
        amplitude = np.full(1001, total * 10 ** (-50 / 20) / 1000, dtype=complex)
        amplitude[500] = 1.0
        centre, _ = scattering_centres(points, amplitude, antenna, antenna, 2.0, K)
        assert abs(len(centre) - left) <= 1
