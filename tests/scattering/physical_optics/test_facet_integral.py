"""The closed form over one triangle against brute force, and the single facet against theory."""

from itertools import permutations

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.facet_integral import (
    NEARLY_FLAT,
    mean_phasor,
    specular_reflection,
    triangle_phases,
)
from tests.reference.facet_integral import (
    bubbles,
    corner_phasors,
    middle_second,
    scattering_amplitude,
)

Floats = NDArray[np.float64]
K = 2 * np.pi / 0.03186


def brute(corners: Floats, gradient: Floats, n: int = 600) -> complex:
    """Mean of exp(-j k g . (r - c)) over a triangle from the centroids of n^2 like ones."""
    a, b, c = corners
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    i, j = i.ravel(), j.ravel()
    up, down = i + j < n, i + j < n - 1
    s = np.concatenate([i[up] + 1 / 3, i[down] + 2 / 3]) / n
    t = np.concatenate([j[up] + 1 / 3, j[down] + 2 / 3]) / n
    points = a + s[:, None] * (b - a) + t[:, None] * (c - a)
    return complex(np.exp(-1j * K * (points - corners.mean(axis=0)) @ gradient).mean())


def closed(corners: Floats, gradient: Floats) -> complex:
    return complex(triangle_phases(corners[None], corners[None].mean(axis=1), gradient[None], K)[0])


def agree(corners: Floats, gradient: Floats) -> bool:
    """Brute force takes phases within a cell, which spread by s, as their middle: it errs by s^2 / 36 at most,
    relatively (35: terms of fourth order); the series leaves out 1e-8."""
    cell = K * np.ptp(corners @ gradient) / 600
    exact = closed(corners, gradient)
    return abs(brute(corners, gradient) - exact) < cell**2 / 35 * abs(exact) + 1e-8


@pytest.mark.sample(3)
@pytest.mark.parametrize("scale", [1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0])
def test_closed_form_is_the_integral(scale: float) -> None:
    """Random triangles of up to a metre, random gradients from nearly along the normal to across."""
    rng = np.random.default_rng(1)
    for _ in range(3):
        assert agree(rng.normal(size=(3, 3)) / 3, rng.normal(size=3) * scale / 3)


def test_closed_form_where_corners_share_their_phase() -> None:
    """An edge across the gradient is a pole of Gordon's edge sum; here nothing happens."""
    corners = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.4, 0.7, 0]])
    for gradient in ([0.0, 1.0, 0.0], [0.0, 0.01, 2.0], [1e-9, 0.3, 0.0]):
        assert agree(corners, np.array(gradient))


def test_series_and_quotient_meet() -> None:
    """At the spread where the series takes over, both sides agree to the term that it leaves out, 9e-9, and a little
    more for the step of the argument itself."""
    corners = np.array([[0.0, 0, 0], [1.0, 0.2, 0], [0.3, 0.7, 0.1]])
    gradient = np.array([1.0, 0.3, -0.2])
    spread = np.ptp(corners @ gradient) * K
    below, above = (gradient * NEARLY_FLAT / spread * (1 + s) for s in (-1e-7, 1e-7))
    assert abs(closed(corners, below) - closed(corners, above)) < 3e-8


def test_halves_make_the_whole() -> None:
    """Additivity, exact to rounding: a triangle is its two halves, each referred to its own centroid."""
    corners = np.array([[0.0, 0, 0], [1.3, 0.2, 0.1], [0.3, 0.9, -0.2]])
    gradient = np.array([0.2, -0.7, 0.1])
    middle = (corners[0] + corners[1]) / 2
    halves = [np.array([corners[0], middle, corners[2]]), np.array([middle, corners[1], corners[2]])]
    phased = [closed(h, gradient) * np.exp(-1j * K * h.mean(axis=0) @ gradient) for h in halves]
    whole = closed(corners, gradient) * np.exp(-1j * K * corners.mean(axis=0) @ gradient)
    assert abs(sum(phased) / 2 - whole) < 1e-12


def dense(count: int = 500) -> Floats:
    """Barycentric coordinates (3, count^2) of the centroids of as many like triangles."""
    i, j = (g.ravel() for g in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    up, down = i + j < count, i + j < count - 1
    s = np.concatenate([i[up] + 1 / 3, i[down] + 2 / 3]) / count
    t = np.concatenate([j[up] + 1 / 3, j[down] + 2 / 3]) / count
    return np.stack([1 - s - t, s, t])


WEIGHTS = dense()


@pytest.mark.parametrize("around", [0.0, 3e5])
@pytest.mark.parametrize("spread", [0.003, 0.02, 0.1, 1.0, 5.0, 30.0])
def test_corner_means_are_those_of_linear_weights(spread: float, around: float) -> None:
    """Each corner's barycentric coordinate times exp(j phi), whose phases are of any size, as those of a whole path; their sum
    is the mean. Dense elements err by (spread / 500)^2 / 35, the series by 1e-5 of phases up to 0.05 rad."""
    rng = np.random.default_rng(5)
    for _ in range(4):
        phases = around + rng.normal(size=3) * spread
        exact = (WEIGHTS * np.exp(1j * (phases @ WEIGHTS))).mean(axis=1)
        result = corner_phasors(phases[:, None], np.zeros((3, 1)))[:, 0]
        np.testing.assert_allclose(result, exact, atol=2e-5 + (np.ptp(phases) / 500) ** 2 / 35)
        assert abs(result.sum() - mean_phasor(phases[:, None])[0]) < 2e-5


@pytest.mark.parametrize(("bend", "error"), [(0.15, 1e-3), (0.3, 4e-3)])
@pytest.mark.parametrize("spread", [0.01, 0.3, 1.0, 5.0, 30.0])
def test_a_bent_phase_is_integrated(spread: float, bend: float, error: float) -> None:
    """Weights 1 and linear ones: interpolation at six points errs by some bend^2 / 25. Of weights that
    differ it leaves out a fifth of bend / 3, which belongs to the corner opposite. A linear phase alone errs by a third of it."""
    rng = np.random.default_rng(5)
    for _ in range(4):
        phases, bends, taper = rng.normal(size=3) * spread, -rng.uniform(0, bend, 3), rng.uniform(0, 1, 3)
        between = sum(4 * bends[k] * WEIGHTS[k - 1] * WEIGHTS[k - 2] for k in range(3))
        field = np.exp(1j * (phases @ WEIGHTS + between))
        result = corner_phasors(phases[:, None], bends[:, None])[:, 0]
        assert abs(result.sum() - field.mean()) < error + 1e-4
        assert abs(taper @ result - np.mean((taper @ WEIGHTS) * field)) < error + bend / 15 * np.ptp(taper) + 1e-4
        assert spread > 1.0 or abs(mean_phasor(phases[:, None])[0] - field.mean()) > 2 * error


def test_corner_means_of_flat_and_steep_triangles_meet() -> None:
    """At the spread where the series takes over, to the terms that it leaves out."""
    shape, bends = np.array([0.0, 0.3, 1.0])[:, None] * NEARLY_FLAT, np.array([0.01, -0.02, 0.03])[:, None]
    below, above = (corner_phasors(shape * (1 + s), bends) for s in (-1e-7, 1e-7))
    np.testing.assert_allclose(below, above, atol=2e-5)


def test_corner_means_follow_their_corners() -> None:
    """Whatever the order of the corners, also where phases are the same."""
    phases, bends = np.array([0.4, -2.0, 5.0]), np.array([0.1, 0.05, -0.1])
    first = corner_phasors(phases[:, None], bends[:, None])[:, 0]
    for order in ([1, 0, 2], [2, 1, 0], [1, 2, 0]):
        turned = corner_phasors(phases[order][:, None], bends[order][:, None])[:, 0]
        np.testing.assert_allclose(turned, first[order], rtol=1e-12)
    alike = corner_phasors(np.array([[1.0], [1.0], [4.0]]), np.zeros((3, 1)))[:, 0]
    assert alike[0] == pytest.approx(alike[1], rel=1e-9)


def test_weights_of_bends_are_exact_by_their_series_too() -> None:
    """Where the largest bend asks for the series or for sines, to a rounding of 1."""
    for largest in (1e-3, 0.1, 0.499, 0.501, 2.0):
        bends = np.linspace(-largest, largest, 30).reshape(3, 10)
        np.testing.assert_allclose(bubbles(bends), 4.0 * (np.exp(1j * bends) - 1.0), atol=2e-11 * largest + 2e-15)


def test_the_middle_corner_comes_second_in_cyclic_order() -> None:
    phases = np.array([list(order) for order in permutations([1.0, 2.0, 3.0])] + [[1.0, 1.0, 4.0], [2.0, 2.0, 2.0]]).T
    index = middle_second(phases)
    ordered = phases.take(index)
    assert ((ordered[0] - ordered[1]) * (ordered[1] - ordered[2]) >= 0.0).all()
    corner = index // phases.shape[1]
    np.testing.assert_array_equal((corner[1:] - corner[:-1]) % 3, 1)
    np.testing.assert_array_equal(index % phases.shape[1], np.broadcast_to(np.arange(8), (3, 8)))


@pytest.mark.parametrize("polarization", ["h", "v"])
def test_plate_at_normal_incidence(polarization: str) -> None:
    """4 pi A^2 / lambda^2, in either polarization, to rounding; and its phase is that of a reflection, -1, times the
    j of the first Fresnel zone: -j."""
    toward, level = np.array([[0.6, 0.64, 0.48]]), np.array([[-0.64, 0.6, 0.0]]) / np.hypot(0.6, 0.64)
    p = level if polarization == "h" else np.cross(toward, level)
    a = scattering_amplitude(-toward, p, p, toward, np.array([2.0 + 0j]), 0.03)[0]
    assert abs(a) ** 2 == pytest.approx(4 * np.pi * 4 / 0.03**2, rel=1e-12)
    assert a / abs(a) == pytest.approx(-1j, abs=1e-12)


def test_specular_reflection_keeps_normal_fields_and_inverts_tangential_ones() -> None:
    """On a conductor the tangential field vanishes: incident plus reflected is along the normal; and waves stay across."""
    rng = np.random.default_rng(2)
    d = rng.normal(size=(50, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    e = np.cross(d, rng.normal(size=(50, 3)))
    n = rng.normal(size=(50, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    turned, field = specular_reflection(d, e, n)
    np.testing.assert_allclose(np.cross(n, e + field), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.einsum("ij,ij->i", turned, field), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(field, axis=1), np.linalg.norm(e, axis=1), rtol=1e-12)
