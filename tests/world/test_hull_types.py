"""Types of hulls: closed parts without coincident facets, their sizes, their draws, and an echo at every aspect."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scattering.physical_optics.mesh_quality import outward_side
from radar_service.scattering.physical_optics.model import OpticalBody
from radar_service.world import shapes
from radar_service.world.hull_types import HULL_TYPES, PLAIN, hull_mesh
from tests.scattering.physical_optics.meshes import cross_section, decibels
from tests.scenes import scene
from tests.world.test_shapes import Floats, normals_and_areas, open_edges

DRAWN = [name for name in HULL_TYPES if name != PLAIN]
SIZES = {"cargo": (103.0, 16.0, 20.0), "ferry": (90.0, 16.0, 14.0), "fishing": (25.0, 7.0, 8.0), "yacht": (12.0, 3.6, 2.5),
         "pilot": (14.0, 4.4, 4.2)}  # fmt: skip


def hull_table(hull_type: str, **more: Any) -> dict[str, Any]:
    sizes = dict(zip(("length_m", "beam_m", "height_m"), SIZES.get(hull_type, (90.0, 16.0, 14.0)), strict=True))
    return {"name": "ship", "shape": "hull", "hull_type": hull_type, **sizes, **more}


@pytest.mark.parametrize("hull_type", DRAWN)
def test_parts_are_closed_wound_outward_and_nowhere_coincident(hull_type: str) -> None:
    for seed in range(4):
        mesh = hull_mesh(hull_type, seed, *SIZES[hull_type])
        outside = outward_side(mesh)
        assert open_edges(mesh) == 0 and (outside == 1).all()


@pytest.mark.parametrize("hull_type", DRAWN)
def test_the_waterline_lies_at_height_0_and_sizes_are_kept(hull_type: str) -> None:
    """The deck has the length and the beam, some roof the height, which masts exceed; the bottom is below the waterline."""
    for seed in range(4):
        length, beam, height = SIZES[hull_type]
        mesh = hull_mesh(hull_type, seed, length, beam, height)
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        np.testing.assert_allclose([high[0], -low[0], high[1], -low[1]], [beam / 2, beam / 2, length / 2, length / 2])
        assert 0.2 * beam < -low[2] < 0.5 * beam and high[2] > 1.2 * height
        assert (np.abs(mesh.vertices[:, 2] - height) < 1e-9).any() and (mesh.vertices[:, 2] == 0.0).any()


@pytest.mark.parametrize("hull_type", DRAWN)
def test_its_sides_are_flared(hull_type: str) -> None:
    """Sides above the waterline look down: by 12 degrees and more at the bow, hardly at all along a ship's middle."""
    mesh = hull_mesh(hull_type, 0, 100.0, 16.0, 14.0)
    corners = mesh.vertices[mesh.faces]
    side = (corners[..., 2].min(axis=1) == 0.0) & (corners[..., 1].min(axis=1) > -49.0)
    normals, _ = normals_and_areas(mesh)
    ahead = corners[side, :, 1].mean(axis=1)
    down = -normals[side, 2]
    assert (down > 0.0).all() and (down[(ahead > 25.0) & (ahead < 45.0)] > 0.2).any()
    assert hull_type not in ("cargo", "ferry") or (down[np.abs(ahead) < 5.0] < 0.02).all()


def test_a_seed_draws_the_parts_and_the_plain_hull_has_none() -> None:
    cargo = [hull_mesh("cargo", seed, *SIZES["cargo"]) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(cargo[0].vertices, cargo[1].vertices)
    assert cargo[0].vertices.shape != cargo[2].vertices.shape or (cargo[0].vertices != cargo[2].vertices).any()
    np.testing.assert_array_equal(hull_mesh(PLAIN, 3, 90.0, 16.0, 14.0).vertices, shapes.hull(90.0, 16.0, 14.0).vertices)


def sections(hull_type: str, sizes_of: str) -> Floats:
    """Cross-sections [m^2] in free space, 2 km off, at 12 aspects that are no round numbers."""
    made = scene([hull_table(sizes_of) | {"hull_type": hull_type}])
    body, turn = OpticalBody.of(made.bodies[0], made.radar, 3), np.deg2rad(np.arange(12) * 30.0 + 7.3)
    return np.array([cross_section(body, np.array([2000.0 * np.sin(a), 2000.0 * np.cos(a), 15.0])) for a in turn])


@pytest.mark.parametrize("hull_type", DRAWN)
def test_there_is_an_echo_at_every_aspect(hull_type: str) -> None:
    """The weakest tenth is within 20 dB of the median: Rayleigh's sum of many alike centres would have 8 dB."""
    drawn = sections(hull_type, hull_type)
    assert decibels(float(np.percentile(drawn, 10) / np.median(drawn))) > -20.0


def test_a_plain_hull_hardly_has_one() -> None:
    """Of the same size its median is 20 dB and more below that of a ferry."""
    assert decibels(float(np.median(sections("ferry", "ferry")) / np.median(sections(PLAIN, "ferry")))) > 20.0


def test_small_sizes_make_a_hull_too() -> None:
    for name in DRAWN:
        mesh = hull_mesh(name, 0, 2.0, 0.8, 0.7)
        assert open_edges(mesh) == 0 and math.isfinite(float(mesh.vertices.sum()))


def test_keys_are_checked() -> None:
    box = {"name": "b", "shape": "box", "length_m": 3, "width_m": 2, "height_m": 1, "hull_type": "cargo"}
    with pytest.raises(rs.SceneError, match=r'hull_type: shape = "box" has none; remove it, or take shape = "hull"'):
        scene([box])
    with pytest.raises(rs.SceneError, match="hull_seed: a plain hull has no parts to draw"):
        scene([hull_table(PLAIN, hull_seed=2)])
    with pytest.raises(rs.SceneError, match="hull_type"):
        scene([hull_table("tug")])


def test_the_loader_draws_by_seed_and_sisters_share_a_mesh() -> None:
    tables = [hull_table("cargo", hull_seed=seed) | {"name": str(n)} for n, seed in enumerate((0, 5, 5))]
    bodies = scene(tables).bodies
    assert bodies[1].mesh is bodies[2].mesh and bodies[0].mesh is not bodies[1].mesh
    assert bodies[0].is_vessel and abs(float(bodies[0].reference[2])) == 0.0
