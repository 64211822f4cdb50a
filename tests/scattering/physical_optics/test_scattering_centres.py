"""Scattering centres have the field of the points that they replace."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.path_fields import PathFields
from radar_service.scattering.physical_optics.scattering_centres import scattering_centres

K = 2 * np.pi / 0.03186
Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def by_way_of(antenna: Floats) -> Callable[[Floats], tuple[Floats, Complexes]]:
    """Whole paths from an antenna and back, and their weights."""

    def at(points: Floats) -> tuple[Floats, Complexes]:
        length = 2 * np.linalg.norm(points - antenna, axis=1)
        return length, 4 / length**2 + 0j

    return at


def fields(points: Floats, amplitude: Complexes, antenna: Floats, cell: float) -> PathFields:
    return PathFields(points, amplitude, *by_way_of(antenna)(points), np.full(len(points), cell))


def merged(points: Floats, amplitude: Complexes, antenna: Floats, cell: float) -> tuple[Floats, Complexes]:
    return scattering_centres(fields(points, amplitude, antenna, cell), by_way_of(antenna), K)


def test_centres_are_exact_for_the_antenna_and_last_for_a_while() -> None:
    """Same field at the antenna, spreading of each point included, but for -50 dB of the strongest centre; after a turn of the
    aspect by d each centre errs by k cell d (sqrt 3: diagonals)."""
    rng = np.random.default_rng(3)
    points = rng.uniform(-20, 20, size=(9000, 3))
    amplitude = rng.normal(size=9000) + 1j * rng.normal(size=9000)
    antenna = np.array([900.0, 700.0, 30.0])
    centre, strength = merged(points, amplitude, antenna, 2.0)
    assert len(centre) < 0.8 * len(points)

    def field(position: Floats, value: Complexes, antenna: Floats) -> complex:
        length, weight = by_way_of(antenna)(position)
        return complex(np.sum(value * weight * np.exp(-1j * K * length))) * 1140.6**2

    dropped = 10 ** (-50 / 20) * np.abs(strength).max()
    assert abs(field(points, amplitude, antenna) - field(centre, strength, antenna)) < 1.1 * dropped  # spreading: 4 %
    turned = antenna + [0.02, -0.02, 0.0]
    error = abs(field(points, amplitude, turned) - field(centre, strength, turned))
    turn = np.hypot(0.02, 0.02) / np.linalg.norm(antenna)
    assert 0.0 < error < K * 2.0 * 1.8 * turn * np.abs(amplitude).sum()
    assert error < 0.05 * abs(field(points, amplitude, turned))


def test_cells_stay_where_they_are_on_the_body() -> None:
    """Silent points elsewhere, or another antenna, leave two points in the cells that they had."""
    points = np.array([[0.1, 0.1, 0.1], [1.9, 1.9, 1.9], [2.1, 0.5, 0.5], [-7.3, 3.0, 1.0]])
    for antenna in (np.array([500.0, 10.0, 20.0]), np.array([-300.0, 400.0, 20.0])):
        for count, centres in ((2, 1), (3, 2), (4, 3)):
            assert len(merged(points[:count], np.ones(count, dtype=complex), antenna, 2.0)[0]) == centres


def test_cells_may_be_flatter_than_long() -> None:
    points = np.array([[0.5, 0.5, 0.2], [0.5, 0.5, 1.8]])
    antenna = np.array([500.0, 10.0, 20.0])
    made = fields(points, np.ones(2, dtype=complex), antenna, 3.0)
    for flattest, centres in ((np.inf, 1), (1.5, 2)):
        assert len(scattering_centres(made, by_way_of(antenna), K, flattest)[0]) == centres


def test_nothing_stays_nothing() -> None:
    centre, strength = merged(np.zeros((0, 3)), np.zeros(0, dtype=complex), np.ones(3), 2.0)
    assert len(centre) == len(strength) == 0


def test_silent_points_make_no_nan() -> None:
    centre, strength = merged(np.ones((3, 3)), np.zeros(3, dtype=complex), np.array([50.0, 0, 0]), 2.0)
    assert np.isfinite(centre).all() and (strength == 0).all()


def test_what_is_left_out_is_faint_even_together() -> None:
    """One strong point and a thousand faint ones that add up to just under -50 dB of it: gone; just over: only what is
    over stays."""
    points = np.arange(1001)[:, None] * np.array([0.0, 10.0, 0.0])
    antenna = np.array([1e5, 0.0, 0.0])
    for total, left in ((0.99, 1), (1.5, 335)):
        amplitude = np.full(1001, total * 10 ** (-50 / 20) / 1000, dtype=complex)
        amplitude[500] = 1.0
        assert abs(len(merged(points, amplitude, antenna, 2.0)[0]) - left) <= 1
