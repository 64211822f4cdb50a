"""Dented plating: against elements with real dents, against Bessel orders, and where nothing may change."""

import functools
from typing import Any

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.special import jv

import radar_service as rs
from radar_service.scattering.physical_optics import plating
from radar_service.scattering.physical_optics.mesh_quality import COPLANAR, shared_edges
from radar_service.scattering.physical_optics.model import OpticalBody
from radar_service.scattering.physical_optics.plating import PlatedWalls
from radar_service.scattering.surface_sampling import normals_and_areas
from tests.measurements.cross_sections import fields, sections_dbsm
from tests.reference import plated_walls
from tests.reference.metal_on_water import Setting
from tests.reference.plated_walls import drawn_wall
from tests.scenes import scene

WAVELENGTH = 299_792_458.0 / 9.41e9
K = 2.0 * np.pi / WAVELENGTH


def scene_of(setting: Setting, body: dict[str, Any]) -> rs.Scene:
    environment = {"multipath": setting.sea, "sea_state": setting.sea_state}
    radar = {
        "range_max_m": 6000,
        "height_m": setting.antenna_height,
        "polarization": setting.polarization,
        "beamwidth_el_deg": 170,
    }
    return rs.load_scene({"radar": radar, "environment": environment, "body": [body]})


def walls_of(scene: rs.Scene) -> PlatedWalls:
    body = scene.bodies[0]
    assert body.mesh is not None
    normal, corners = normals_and_areas(body.mesh)[0], body.mesh.vertices[body.mesh.faces]
    one, other = (edge // 3 for edge in shared_edges(body.mesh))
    flat = np.linalg.norm(np.cross(normal[one], normal[other]), axis=1) < COPLANAR
    links = coo_array((np.ones(int(flat.sum())), (one[flat], other[flat])), shape=(len(normal), len(normal)))
    patch = connected_components(links, directed=False)[1]
    spans = np.array([np.ptp(corners[patch == number].reshape(-1, 3), axis=0) for number in range(patch.max() + 1)])[patch]
    walls = PlatedWalls.of(body.mesh, normal, spans, body.plating, scene.radar.wavelength)
    assert walls is not None
    return walls


@functools.cache
def both(seed: int, upright: bool) -> tuple[complex, complex, complex]:
    """Fields [m] of a drawn wall: the engine's, that of elements, and that of elements of the flat wall."""
    wall = drawn_wall(seed, upright)
    scene = scene_of(wall.setting, wall.body())
    walls = walls_of(scene)
    depths = walls.drawn[int(walls.wall[0])]
    flat = plated_walls.field(wall, 0.0 * depths, walls.first)
    return complex(fields(scene, [0.0])[0]), plated_walls.field(wall, depths, walls.first), flat


def check(count: int, most_rms: float) -> None:
    """Mean power and coherent loss of walls each within 0.5 dB of what elements with dents have; rms error of |field| over rms
    |field| below a limit. Powers are over what a flat wall returns along its normal in free space."""
    drawn = [both(seed, False) for seed in range(count)]
    unit = np.array([np.sqrt(4.0 * np.pi) * wall.width * wall.height / WAVELENGTH for wall in map(drawn_wall, range(count))])
    engine, exact, _ = (np.abs([each[n] for each in drawn]) / unit for n in range(3))
    assert abs(10.0 * np.log10(np.mean(engine**2) / np.mean(exact**2))) < 0.5
    assert np.sqrt(np.mean((engine - exact) ** 2) / np.mean(exact**2)) < most_rms
    upright = [both(seed, True) for seed in range(count)]
    loss, exact_loss = (20.0 * np.log10(np.mean([abs(each[n] / each[2]) for each in upright])) for n in (0, 1))
    assert abs(loss - exact_loss) < 0.5 and -7.0 < exact_loss < -0.5


def test_walls_against_elements_with_real_dents() -> None:
    check(8, 0.15)  # one wall near its normal holds most of the power of eight


@pytest.mark.study
def test_300_walls_against_elements_with_real_dents() -> None:
    check(300, 0.04)  # measured: power 0.02 dB, loss 0.006 dB, rms 0.02


HULLS = ("plain", "cargo", "ferry", "fishing", "yacht", "pilot")


@pytest.mark.parametrize("kind", HULLS)
def test_the_walls_of_a_hull_are_those_that_the_documents_say(kind: str) -> None:
    """Depths of their panels have the mean of the table and a quarter of it as deviation: 4 sigma of so many even draws."""
    plating = {"dent_m": 0.004, "frame_m": 0.7, "panel_height_m": 2.0}
    table = {"shape": "hull", "hull_type": kind, "length_m": 24.0, "beam_m": 7.0, "height_m": 8.0, "plating": plating}
    made = scene([{"name": "hull", "position_m": [0, 2000, 0], "scattering": "optics", **table}])
    walls, mesh = walls_of(made), made.bodies[0].mesh
    assert mesh is not None
    expected = plated_walls.ways_of_walls(mesh.vertices[mesh.faces], plating["frame_m"])
    assert (expected >= 0).sum() > 8
    np.testing.assert_array_equal(np.where(walls.axis >= 0, walls.wall, -1), expected)
    shares, sigma = walls.drawn / 0.004, 0.25 / np.sqrt(walls.drawn.size)
    assert shares.mean() == pytest.approx(1.0, abs=4 * sigma)
    assert shares.std() == pytest.approx(0.25, abs=4 * sigma / np.sqrt(5))  # of even draws kurtosis is 1.8: (1.8 - 1) / 4


def side(dent: float | None = 0.004, **more: Any) -> dict[str, Any]:
    """A box of 30 x 3 m walls in free space."""
    table = {"name": "box", "shape": "box", "length_m": 30.0, "width_m": 4.0, "height_m": 3.0, "position_m": [0, 2000, 0]}
    return table | ({} if dent is None else {"plating": {"dent_m": dent} | more})


def seen(table: dict[str, Any], off_normal_deg: float, seed: int | None = None) -> float:
    """Cross-section [dBsm] of the box that is turned from broadside."""
    body = table if seed is None else table | {"plating": table["plating"] | {"seed": seed}}
    return float(
        sections_dbsm(scene([body | {"heading_deg": 90.0 + off_normal_deg}], environment={"earth": "flat"}), [0.0])[0]
    )


@pytest.mark.parametrize("dent", [0.004, 0.008])
def test_lobes_are_bessel_functions_where_all_panels_are_alike(dent: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over the flat wall at its normal, order m has J_m(k w)^2 at m lambda / (2 s) (Jacobi-Anger). 0.4 dB: of the distance, at
    which the wall's phase bends by 0.3 rad, and of frames that the wall does not hold a whole number of."""
    monkeypatch.setattr(plating, "SPREAD", 0.0)
    flat = seen(side(None), 0.0)
    for order in range(3):
        turn = np.rad2deg(np.arcsin(order * WAVELENGTH / (2.0 * 0.75)))
        lobe = seen(side(dent, frame_m=0.75), turn)
        assert lobe - flat == pytest.approx(20.0 * np.log10(abs(jv(order, K * dent)) * np.cos(np.deg2rad(turn))), abs=0.4)


def test_far_from_the_normal_walls_are_flat() -> None:
    """Beyond the orders that count, to the last bit; and a dent of 0, or no table, changes nothing anywhere."""
    assert seen(side(0.004), 15.0) == seen(side(None), 15.0)
    assert seen(side(0.0), 0.0) == seen(side(None), 0.0)


def test_dents_belong_to_the_hull_and_to_the_seed() -> None:
    """The same aspect gives the same, twice; another seed another."""
    assert seen(side(), 0.7) == seen(side(), 0.7) != seen(side(), 0.7, seed=1)


def test_the_field_is_continuous_where_dents_fade() -> None:
    """By aspect, at either end of the fading, its steps change by little from one to the next."""
    for turns in (0.0, plating.FADING):
        edge = np.rad2deg(np.arcsin((plating.ORDERS + 2.0 * K * 0.004 + turns) * WAVELENGTH / (2.0 * 0.7)))
        turning = side() | {"length_m": 4.0, "course_deg": 90.0 + edge - 0.01, "turn_rate_deg_s": 0.001}
        steps = np.abs(np.diff(fields(scene([turning], environment={"earth": "flat"}), np.arange(20.0))))
        assert np.abs(np.diff(steps)).max() < 0.1 * steps.max()


def test_only_large_walls_are_plated() -> None:
    """Neither decks nor bars are: of a ferry its sides and houses, of a cylinder nothing."""
    table = {"name": "f", "shape": "hull", "hull_type": "ferry", "length_m": 90.0, "beam_m": 16.0, "height_m": 14.0}
    made = scene([table, {"name": "c", "shape": "cylinder", "radius_m": 0.3, "height_m": 5.0, "plating": {}}])
    optics, bare = (OpticalBody.of(body, made.radar, 1).optics for body in made.bodies)
    assert optics.walls is not None and bare.walls is None
    plated = optics.walls.axis >= 0
    assert (np.abs(optics.pieces.normal[plated, 2]) < 0.5).all() and optics.pieces.spans[plated, 2].min() > 0.7
    assert 0.02 < plated.mean() < 0.5


def test_which_bodies_are_dented() -> None:
    hull = {"shape": "hull", "length_m": 50.0, "beam_m": 9.0, "height_m": 9.0}
    tables = [
        hull,
        hull | {"hull_type": "cargo"},
        hull | {"hull_type": "plain", "plating": {}},
        hull | {"hull_type": "cargo", "plating": {"dent_m": 0}},
    ]
    bodies = scene([{"name": str(n), **table} for n, table in enumerate(tables)]).bodies
    depths = [None if body.plating is None else body.plating.depth for body in bodies]
    assert depths == [None, 0.004, 0.004, 0.0]
    with pytest.raises(rs.SceneError, match="plating: a height map is land"):
        scene([{"name": "h", "heightmap": "h.png", "plating": {}}])
