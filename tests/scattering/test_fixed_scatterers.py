"""Fixed scatterers: cross-sections by closed form, and what each model states of itself."""

from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

import radar_service as rs
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.declared_scattering import DeclaredScattering
from radar_service.scattering.fixed_scatterers import DiffuseScattering, FixedScatterers, cell_scatterers
from radar_service.scattering.model import BearingWedge, BodyEchoes, Conditions, Instant, ScatteringContext, ScatteringModel
from radar_service.trace.embree import RayCount
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.body import Body
from tests.scenes import point, scene

Model = TypeVar("Model", bound=ScatteringModel)
LEFT, RIGHT = np.array([-300.0, 0.0, 15.0]), np.array([500.0, 100.0, 15.0])
PLATE = {"name": "p", "shape": "plate", "width_m": 4, "height_m": 2, "position_m": [0, 800, 15], "heading_deg": 180,
         "material": "concrete"}  # fmt: skip
FLAT = {"earth": "flat"}


def context(made: rs.Scene, seed: int = 3, earth: float = np.inf, **fidelity: Any) -> ScatteringContext:
    settings = replace(PRESETS["balanced"], **fidelity)
    antenna = made.antenna(0.0)[0]
    return ScatteringContext(made.radar, settings, seed, antenna, made.environment, made.bodies, earth, scene_name=made.name)


def build(model: type[Model], made: rs.Scene, **settings: Any) -> Model:
    return model.build(made.bodies, np.arange(len(made.bodies)), context(made, **settings))


def instant(made: rs.Scene, time: float = 0.0, earth: float = np.inf, **more: Any) -> Instant:
    return Instant(time, OcclusionScene(made.bodies, earth), 1e5, **more)


def total(echoes: BodyEchoes) -> float:
    """Sum of the cross-sections [m^2]."""
    return float(np.sum(np.abs(echoes.amplitude) ** 2))


def cosines(end: np.ndarray) -> float:
    """Of the incidence on the plate, which faces south."""
    offset = end - np.array([0.0, 800.0, 15.0])
    return float(-offset[1] / np.linalg.norm(offset))


def test_a_diffuse_plate_has_the_cosine_of_incidence() -> None:
    """gamma A cos i; the plate of 4 m turns the cosine by 0.5 % from end to end: 0.1 % in the mean."""
    made = scene([PLATE], environment=FLAT)
    model, gamma = build(DiffuseScattering, made), made.bodies[0].material.gamma
    for antenna in (LEFT, RIGHT):
        assert total(model.echoes(antenna, instant(made))) == pytest.approx(gamma * 8 * cosines(antenna), rel=2e-3)


def test_what_is_one_sided_reflects_to_where_it_faces() -> None:
    """The same plate as land, from the front and from behind."""
    made = scene([PLATE], environment=FLAT)
    sheet = replace(made.bodies[0], one_sided=True)
    model = DiffuseScattering.build([sheet], np.arange(1), context(made))
    beyond = np.array([300.0, 1600.0, 15.0])
    ahead, behind = (total(model.echoes(end, instant(made))) for end in (LEFT, beyond))
    plain, back = (total(build(DiffuseScattering, made).echoes(end, instant(made))) for end in (LEFT, beyond))
    assert ahead == plain > 0.0 and behind == 0.0 < back


HULL = {"name": "h", "shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 9, "position_m": [30, 700, 0]}
STANCES = {
    "at rest": {"heading_deg": 77},
    "under way": {"course_deg": 160, "speed_kn": 9},
    "rolling": {"course_deg": 310, "speed_kn": 4, "roll_deg": 12, "roll_period_s": 7},
}


def of_sheets(made: rs.Scene) -> tuple[Body, ...]:
    """The bodies, not known to be solid: rays alone tell what they hide of themselves."""
    assert all(body.mesh is not None and body.mesh.solid for body in made.bodies)
    return tuple(replace(body, mesh=body.mesh and replace(body.mesh, solid=False)) for body in made.bodies)


@pytest.mark.parametrize("kind", [{"material": "wood"}, {"rcs_dbsm": 20}], ids=["diffuse", "declared"])
@pytest.mark.parametrize("stance", STANCES.values(), ids=STANCES)
def test_a_solid_body_hides_what_faces_away(kind: dict[str, Any], stance: dict[str, Any]) -> None:
    """The same echoes as with rays to all scatterers, though fewer than seven in ten get one."""
    made = scene([{**HULL, **kind, **stance}], environment=FLAT)
    model, key = DiffuseScattering if "material" in kind else DeclaredScattering, np.arange(1)
    by_rays = model.build(of_sheets(made), key, context(made))
    for time in (0.0, 4.0, 9.0):
        rays, of_all = RayCount(), RayCount()
        echoes, expected = (
            source.echoes(LEFT, Instant(time, OcclusionScene(made.bodies, np.inf, rays=count), 1e5))
            for source, count in ((build(model, made), rays), (by_rays, of_all))
        )
        np.testing.assert_allclose(echoes.position, expected.position, rtol=1e-12)
        np.testing.assert_allclose(echoes.amplitude, expected.amplitude, rtol=1e-12)
        assert len(echoes) and rays.rays < 0.7 * of_all.rays


def test_what_stands_around_the_antenna_and_what_is_transparent_shows_its_back() -> None:
    """From within a box every side faces away; a body that the plan lets occlude nothing has echoes of its back."""
    made = scene([{"name": "b", "shape": "box", "length_m": 40, "width_m": 8, "height_m": 9, "material": "wood"}])
    antenna, model = np.array([0.0, 0.0, 4.0]), build(DiffuseScattering, made)
    assert len(model.echoes(antenna, instant(made))) == model.scatterers.sum()
    away = scene([{**HULL, "material": "wood", "speed_kn": 5}])
    transparent = Instant(0.0, OcclusionScene(away.bodies, np.inf, without=[0]), 1e5)
    assert len(build(DiffuseScattering, away).echoes(LEFT, transparent)) == build(DiffuseScattering, away).scatterers.sum()


def cut_hill(folder: Path) -> rs.Scene:
    """Land 400 m wide and deep that the map cuts 1 km to the north, where it is 20 m high; behind it falls to 2 m."""
    np.save(folder / "hill.npy", np.repeat(np.linspace(2.0, 20.0, 21)[:, None], 21, axis=1))
    land = {"name": "land", "heightmap": "hill.npy", "extent_m": [400, 400], "position_m": [0, 1200, 0], "material": "land"}
    made = rs.load_scene({"radar": {"range_max_m": 2500}, "environment": FLAT, "body": [land]}, folder=folder)
    assert made.bodies[0].mesh is not None
    return made


@pytest.mark.parametrize("antenna", [(0.0, 0.0, 15.0), (-900.0, 300.0, 5.0)])
def test_the_edge_of_a_map_is_a_wall_and_hides_the_slope_behind_it(tmp_path: Path, antenna: tuple[float, ...]) -> None:
    """The wall of 400 x 20 m has gamma A cos i, its mean over 1,000 points; the slope behind it nothing.

    Of 3,950 scatterers 1 / 21 lie below the sea, with a standard deviation of 14: 3 sigma are 1.1 % of the others.
    """
    made, end = cut_hill(tmp_path), np.array(antenna)
    echoes = build(DiffuseScattering, made, scatterers_per_cell=64).echoes(end, instant(made))
    wall = np.stack([*np.meshgrid(np.linspace(-198, 198, 100), [1000.0], np.linspace(1, 19, 10))], axis=-1).reshape(-1, 3)
    line = end - wall
    expected = made.bodies[0].material.gamma * 8000.0 * np.mean(-line[:, 1] / np.linalg.norm(line, axis=1))
    north = echoes.position[:, 1] + 1200.0
    of_wall = np.abs(north - 1000.0) < 1e-6
    assert np.sum(np.abs(echoes.amplitude[of_wall]) ** 2) == pytest.approx(expected, rel=0.011)
    assert (np.abs(echoes.position[~of_wall, 0]) > 199.0).all()


def test_maps_that_share_an_edge_show_no_wall_there(tmp_path: Path) -> None:
    """A slope of 2 to 38 m in two maps of 400 x 400 m; 12,000 scatterers, of which 800 lie on the hidden walls between them."""
    for name, low in (("near", 2.0), ("far", 20.0)):
        np.save(tmp_path / f"{name}.npy", np.repeat(np.linspace(low + 18.0, low, 21)[:, None], 21, axis=1))
    land = {"extent_m": [400, 400], "material": "land"}
    bodies = [
        {**land, "name": "near", "heightmap": "near.npy", "position_m": [0, 1200, 0]},
        {**land, "name": "far", "heightmap": "far.npy", "position_m": [0, 1600, 0]},
    ]
    made = rs.load_scene({"radar": {"range_max_m": 2500}, "environment": FLAT, "body": bodies}, folder=tmp_path)
    echoes = build(DiffuseScattering, made, scatterers_per_cell=64).echoes(np.array([0.0, 0.0, 15.0]), instant(made))
    north = echoes.position[:, 1] + np.array([1200.0, 1600.0])[echoes.body]
    assert np.count_nonzero(np.abs(north - 1400.0) < 1e-6) == 0 < np.count_nonzero(np.abs(north - 1000.0) < 1e-6)
    assert (np.bincount(echoes.body) > 1000).all()


def test_scatterers_must_be_visible() -> None:
    """A wall before an antenna takes all echoes there, and none elsewhere."""
    wall = {"name": "w", "shape": "plate", "width_m": 40, "height_m": 60, "position_m": [250, 450, 20], "rcs_dbsm": 0,
            "heading_deg": 180}  # fmt: skip
    made = scene([PLATE, wall], environment=FLAT)
    model = DiffuseScattering.build(made.bodies[:1], np.array([0]), context(made))
    assert len(model.echoes(LEFT, instant(made))) > 40 and len(model.echoes(RIGHT, instant(made))) == 0


@pytest.mark.parametrize("model", [DiffuseScattering, DeclaredScattering])
def test_scatterers_depend_on_names_alone(model: type[FixedScatterers]) -> None:
    """Bodies put before, after or taken away change no scatterer of the others; another name, scene or seed changes all."""
    box = {"shape": "box", "length_m": 60, "width_m": 9, "height_m": 9, "heading_deg": 30, "material": "wood"}
    box |= {"rcs_dbsm": 5} if model is DeclaredScattering else {}
    named = {name: {**box, "name": name, "position_m": [0, 500, 0]} for name in "abc"}  # alike but for their names

    def positions(names: str, wanted: str, scene_name: str = "test", seed: int = 3) -> np.ndarray:
        made = scene([named[name] for name in names])
        settings = replace(context(made), scene_name=scene_name, seed=seed)
        return model.sample(made.bodies[names.index(wanted)], settings).position

    alone = positions("b", "b")
    for names in ("ab", "cba", "bc"):
        np.testing.assert_array_equal(positions(names, "b"), alone)
    assert not np.array_equal(positions("ab", "a"), alone)
    assert not np.array_equal(positions("b", "b", scene_name="other"), alone)
    assert not np.array_equal(positions("b", "b", seed=4), alone)


def test_echoes_of_moving_bodies_turn_with_them() -> None:
    """The plate under way, heading west at 10 s: seen from there as from the south before."""
    moving = {**PLATE, "heading_deg": 270, "course_deg": 0, "speed_kn": 10}
    made, still = scene([moving], environment=FLAT), scene([{**PLATE, "heading_deg": 270}], environment=FLAT)
    shift = np.array([0.0, 10 * 10 * 1852 / 3600, 0.0])
    west = np.array([-700.0, 790.0, 15.0])
    late = build(DiffuseScattering, made).echoes(west + shift, instant(made, 10.0))
    same = build(DiffuseScattering, still).echoes(west, instant(still))
    np.testing.assert_array_equal(late.position, same.position)
    np.testing.assert_allclose(late.amplitude, same.amplitude, rtol=1e-9)


def test_a_sector_leaves_out_what_lies_beside_it_and_keeps_declared_bodies_whole() -> None:
    """Of a diffuse quay the part within the bearings; of a declared one all or nothing, as its scatterers share."""
    quay = {"name": "q", "shape": "box", "length_m": 10, "width_m": 800, "height_m": 20, "position_m": [0, 500, 0]}
    antenna = np.array([0.0, 0.0, 15.0])
    sector = BearingWedge(antenna, 0.0, 0.3, 1.0)
    for model, more in ((DiffuseScattering, {"material": "concrete"}), (DeclaredScattering, {"rcs_dbsm": 10})):
        made = scene([{**quay, **more}], environment=FLAT)
        source = build(model, made)
        whole = source.echoes(antenna, instant(made))
        part = source.echoes(antenna, instant(made, wedge=sector))
        inside = sector.contains(whole.position + [0, 500, 0])
        kept = inside if model is DiffuseScattering else np.ones(len(whole), dtype=np.bool_)
        assert 4 < inside.sum() < len(whole) - 4
        np.testing.assert_array_equal(part.position, whole.position[kept])
        assert len(source.echoes(antenna, instant(made, wedge=BearingWedge(antenna, np.pi, 0.3, 1.0)))) == 0


def test_stated_maxima_are_hardly_ever_exceeded() -> None:
    """Of 300 seeds of a plate of many scatterers, speckle exceeds ten times its mean in none (e^-10 each), its maximum
    cross-section being that of its area; a steady point's maximum is what it declares."""
    made = scene([{**PLATE, "position_m": [0, 800, 15]}], environment=FLAT)
    antenna, powers = made.antenna(0.0)[0], []
    for seed in range(300):
        echoes = build(DiffuseScattering, made, seed=seed).echoes(antenna, instant(made))
        powers.append(abs(echoes.amplitude.sum()) ** 2)
    limit = DiffuseScattering.max_rcs(made.bodies[0], made.radar, PRESETS["balanced"])
    assert limit / 4 < max(powers) < limit
    (steady, slow) = scene([point("t", 0, 500), point("s", 0, 600, swerling=1)]).bodies
    limits = [DeclaredScattering.max_rcs(body, made.radar, PRESETS["balanced"]) for body in (steady, slow)]
    assert limits == pytest.approx([10.0, 100.0])


def test_more_scatterers_err_less() -> None:
    made = scene([PLATE])
    body = made.bodies[0]
    errors = [
        DiffuseScattering.error_db(
            body, Conditions.of_scene(made, replace(PRESETS["balanced"], scatterers_per_cell=n), 10_000)
        )
        for n in (1, 4, 16)
    ]
    assert errors[0] == pytest.approx(2 * errors[1]) == pytest.approx(4 * errors[2])  # type: ignore[operator]
    sparse = DiffuseScattering.error_db(body, Conditions.of_scene(made, PRESETS["reference"], 48))
    assert sparse is not None and sparse > errors[2]  # type: ignore[operator]
    assert DeclaredScattering.error_db(body, Conditions.of_scene(made, PRESETS["balanced"], 1)) == 0.0


def test_what_the_limit_of_scatterers_leaves_to_a_cell_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """100 points on 40,000 m^2, 800 m off in cells of 1.9986 x 54.5 m: 0.27 a cell, within 1 % as its triangles lie 803 m off."""
    made = scene([{**PLATE, "width_m": 400, "height_m": 100}])
    body, radar = made.bodies[0], made.radar
    conditions = Conditions.of_scene(made, PRESETS["balanced"], 100)
    assert "4 scatterers per resolution cell" in DiffuseScattering.description(body, conditions, "computed once")
    free = DiffuseScattering.error_db(body, conditions)
    monkeypatch.setattr("radar_service.scattering.fixed_scatterers.MAX_SCATTERERS", 100)
    left = 100 * radar.range_step * radar.beamwidth * 800 / 40_000
    assert cell_scatterers(body, conditions) == pytest.approx(left, rel=0.01)
    text = DiffuseScattering.description(body, conditions, "computed once")
    assert "0.273 scatterers per resolution cell; the limit of 100 allows no 4" in text
    error = DiffuseScattering.error_db(body, conditions)
    assert free is not None and error is not None and error > free
