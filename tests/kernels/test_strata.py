"""Kernels that sample surfaces against numpy."""

from typing import Any

import numpy as np
import pytest

from radar_service.scattering.surface_sampling import Scatterers, sample_surface
from radar_service.world.body import Mesh
from tests.kernels.both import both
from tests.scenes import scene

SHAPES: dict[str, dict[str, Any]] = {
    "box, whose faces are sampled one by one": {"shape": "box", "length_m": 20, "width_m": 12, "height_m": 9},
    "hull": {"shape": "hull", "length_m": 30, "beam_m": 10, "height_m": 9},
    "hull of a kilometre": {"shape": "hull", "length_m": 1000, "beam_m": 2, "height_m": 2},
    "ball": {"shape": "sphere", "radius_m": 2},
}


def compared(mesh: Mesh, count: int, sea: float) -> Scatterers:
    """Scatterers of a mesh, the same by kernels and numpy: those drawn equal, heights to the rounding of sums of 32."""
    density = np.random.default_rng(2).uniform(1e-6, 3e-6, len(mesh.faces))
    compiled, by_numpy = both(lambda: sample_surface(mesh, density, np.random.default_rng(1), count, sea=sea))
    for name in ("position", "normal", "triangle", "phasor"):
        np.testing.assert_array_equal(getattr(compiled, name), getattr(by_numpy, name))
    for name in ("area", "middle", "span"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(by_numpy, name), rtol=1e-12, atol=1e-13)
    np.testing.assert_array_equal(compiled.span > 0.0, by_numpy.span > 0.0)  # else an echo is that of a point
    return compiled


@pytest.mark.parametrize("sea", [-np.inf, 2.0, 50.0], ids=["no sea", "afloat", "sunk"])
@pytest.mark.parametrize("count", [1, 20, 48, 300, 700])
@pytest.mark.parametrize("shape", SHAPES)
def test_scatterers_are_those_of_numpy(shape: str, count: int, sea: float) -> None:
    """One, a few, those of a body, most strata, and more than these, along the mesh."""
    (body,) = scene([{**SHAPES[shape], "name": "b", "material": "wood", "position_m": [0, 500, 0]}]).bodies
    assert body.mesh is not None
    drawn = compared(body.mesh, count, sea)
    assert len(drawn) >= count


def test_triangles_without_area_and_equal_features_change_nothing() -> None:
    """Two equal squares, one upon the other, and a triangle of one point: points of both have equal features."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float64)
    mesh = Mesh(vertices, np.array([[0, 1, 2], [0, 2, 3], [0, 0, 0], [0, 1, 2], [0, 2, 3]]))
    drawn = compared(mesh, 48, -np.inf)
    assert not (drawn.triangle == 2).any() and {0, 1, 3, 4} == {*drawn.triangle.tolist()}
