"""The closed form over one triangle against brute force, and the single facet against theory."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.facet_integral import (
    NEARLY_FLAT,
    mean_phasor,
    polarization_of,
    scattering_amplitude,
    specular_reflection,
    triangle_phases,
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


@pytest.mark.parametrize(("bend", "error"), [(0.15, 1e-3), (0.3, 4e-3)])
@pytest.mark.parametrize("spread", [0.01, 0.3, 1.0, 5.0, 30.0])
def test_a_bent_phase_and_a_taper_are_integrated(spread: float, bend: float, error: float) -> None:
    """Against 360,000 small triangles, whose own error is (spread / 600)^2 / 36 of 1: interpolation at six points
    errs by some bend^2 / 25, and leaves out bend times taper. Linear phase alone errs by a third of the bend."""
    rng = np.random.default_rng(5)
    i, j = (g.ravel() for g in np.meshgrid(np.arange(600), np.arange(600), indexing="ij"))
    up, down = i + j < 600, i + j < 599
    s = np.concatenate([i[up] + 1 / 3, i[down] + 2 / 3]) / 600
    t = np.concatenate([j[up] + 1 / 3, j[down] + 2 / 3]) / 600
    weights = np.stack([1 - s - t, s, t])
    for _ in range(4):
        phases, bends, tapers = rng.normal(size=3) * spread, -rng.uniform(0, bend, 3), rng.normal(size=3) * 0.005
        between = sum(4 * bends[k] * weights[k - 1] * weights[k - 2] for k in range(3))
        exact = np.mean(np.exp(1j * (phases @ weights + between)) * (1 + tapers @ weights))
        result = mean_phasor(phases[:, None], bends[:, None], tapers[:, None])[0]
        assert abs(result - exact) < error + 1e-4
        assert spread > 1.0 or abs(mean_phasor(phases[:, None])[0] - exact) > 2 * error


@pytest.mark.parametrize("polarization", ["h", "v"])
def test_plate_at_normal_incidence(polarization: str) -> None:
    """4 pi A^2 / lambda^2, in either polarization, to rounding; and its phase is that of a reflection, -1, times the
    j of the first Fresnel zone: -j."""
    toward = np.array([[0.6, 0.64, 0.48]])
    p = polarization_of(toward, polarization)
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


def test_polarizations_are_level_and_upright() -> None:
    toward = np.array([[0.6, 0.64, 0.48], [0.0, 0.0, 1.0]])
    h, v = polarization_of(toward, "h"), polarization_of(toward, "v")
    assert h[:, 2] == pytest.approx(0.0)
    for p in (h, v):
        assert np.linalg.norm(p, axis=1) == pytest.approx(1.0)
        assert np.einsum("ij,ij->i", p, toward) == pytest.approx(0.0, abs=1e-12)
    assert np.einsum("ij,ij->i", h, v) == pytest.approx(0.0, abs=1e-12)
