"""The short modules of scattering, each under its name."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service
import radar_service as rs
from radar_service.numerics.ragged import spans
from radar_service.plug_ins import names as part_names
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.declared_cells import cell_spacing
from radar_service.scattering.declared_scattering import DeclaredScattering
from radar_service.scattering.fixed_scatterers import DiffuseScattering, FixedScatterers
from radar_service.scattering.model import ALL_PATHS, BearingWedge, BodyEchoes, BodyRun, Conditions, RunError
from radar_service.scattering.models import model_named, scattering_model
from radar_service.scattering.physical_optics.model import FACETS_DB, REBOUNCES_DB, PhysicalOptics
from radar_service.scattering.rays import RaySampledSurfaces
from radar_service.scattering.resting_points import MapCells
from radar_service.scattering.scatterer_set import ScattererSet, build_scatterers
from radar_service.scattering.surface_sampling import density_db, surface_db
from radar_service.world.body import MATERIALS
from radar_service.world.error import SceneError
from radar_service.world.poses import map_from_bodies
from tests.scattering.test_fixed_scatterers import FLAT, build, context, instant
from tests.scenes import point, scene

# model: the records that models exchange: sectors against every bearing, and echoes whose shapes fit.
ANTENNA = np.array([100.0, -50.0, 15.0])


@pytest.mark.parametrize("middle", [0.0, 1.0, np.pi, 4.0, 6.2])
@pytest.mark.parametrize("half", [0.05, 1.0, 2.0, 3.1, np.pi])
def test_a_sector_holds_the_bearings_within_it_and_all_that_is_near(middle: float, half: float) -> None:
    rng = np.random.default_rng(1)
    position = ANTENNA + np.stack([*rng.uniform(-500, 500, (2, 3000)), np.zeros(3000)], axis=1)
    east, north, _ = (position - ANTENNA).T
    off = np.abs((np.arctan2(east, north) - middle + np.pi) % (2 * np.pi) - np.pi)
    expected = (off <= half) | (np.hypot(east, north) <= 60)
    np.testing.assert_array_equal(BearingWedge(ANTENNA, middle, half, 60.0).contains(position), expected)


@pytest.mark.parametrize("half", [0.05, 1.0, 2.5])
def test_a_circle_counts_where_a_part_of_it_lies_in_the_sector(half: float) -> None:
    """Against 360 points on each circle's edge, of 1 to 80 m; those that touch by less than a point's spacing are left out."""
    rng = np.random.default_rng(2)
    middle, sector = rng.uniform(-500, 500, (300, 2)), BearingWedge(ANTENNA, 1.0, half, 60.0)
    size, turn = rng.uniform(1, 80, 300), np.linspace(0, 2 * np.pi, 360, endpoint=False)
    position = ANTENNA + np.column_stack([middle, np.zeros(300)])
    counted = sector.contains(position, size)

    def any_part(radius: np.ndarray) -> np.ndarray:
        edge = position[:, None, :2] + radius[:, None, None] * np.stack([np.sin(turn), np.cos(turn)], axis=1)
        flat = np.column_stack([edge.reshape(-1, 2), np.zeros(edge.shape[0] * 360)])
        return np.asarray(sector.contains(flat).reshape(300, 360).any(axis=1) | sector.contains(position))

    assert counted[any_part(size)].all()
    assert not counted[~any_part(size * 1.001)].any()
    assert 10 < counted.sum() < 290 or half > 2


def test_echoes_whose_shapes_do_not_fit_are_refused() -> None:
    good = np.zeros((2, 3)), np.zeros(2, dtype=complex), *np.zeros((2, 2), dtype=np.int64), np.zeros(2)
    assert len(BodyEchoes(*good)) == 2
    for wrong in range(len(good)):
        parts = list(good)
        parts[wrong] = parts[wrong][:1]
        with pytest.raises(AssertionError):
            BodyEchoes(*parts)


def test_echoes_of_points_stand_for_all_paths_and_join_in_order() -> None:
    first, second = (BodyEchoes.of_points(np.full((n, 3), n), np.ones(n, dtype=complex), np.full(n, n)) for n in (2, 3))
    assert (first.path == ALL_PATHS).all() and not first.height_span.any()
    joined = BodyEchoes.joined([first, second])
    assert joined.body.tolist() == [2, 2, 3, 3, 3] and joined.chosen(np.array([1, 2])).position[:, 0].tolist() == [2, 3]
    assert len(BodyEchoes.joined([])) == 0


# models: the registry: each body has the model that its scene file names.
PACKAGE = Path(radar_service.__file__).parent
BOX = {"name": "b", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9, "position_m": [0, 300, 0]}
NAMES = part_names("scattering")
KINDS: list[tuple[dict[str, Any], type]] = [
    (point("p", 0, 500), DeclaredScattering),
    ({**BOX, "rcs_dbsm": 3}, DeclaredScattering),
    ({**BOX, "scattering": "diffuse"}, DiffuseScattering),
    ({**BOX, "material": "wood"}, DiffuseScattering),
    ({**BOX, "scattering": "optics"}, PhysicalOptics),
]


@pytest.mark.parametrize(("body", "model"), KINDS)
def test_bodies_have_the_model_of_their_file(body: dict[str, Any], model: type) -> None:
    (made,) = scene([body]).bodies
    assert scattering_model(made) is model
    assert scattering_model(made, "sobol") is (RaySampledSurfaces if model is DiffuseScattering else model)


def test_a_scene_file_may_give_every_name_of_the_registry_and_no_other() -> None:
    for name in NAMES:
        scene([{**BOX, "scattering": name, **({"rcs_dbsm": 3} if name == "rcs" else {})}])
    with pytest.raises(SceneError, match=".*".join(NAMES)):
        scene([{**BOX, "scattering": "mirror"}])


def test_materials_name_models_of_the_registry() -> None:
    assert {material.scattering for material in MATERIALS.values()} <= set(NAMES)


MODELS = [*map(model_named, NAMES), RaySampledSurfaces]


def test_models_that_depend_on_aspect_have_what_the_beam_asks_of_them() -> None:
    methods = ("body_echoes", "casters", "coherence", "upright")
    assert {model.by_aspect for model in MODELS} == {False, True}
    for model in MODELS:
        assert [hasattr(model, name) for name in methods] == [model.by_aspect] * len(methods), model


def test_only_the_registry_and_the_studies_name_a_model() -> None:
    """What else needs to know of a model asks it: a new one is a file here and a line in the registry."""
    names = re.compile("|".join([*(model.__name__ for model in MODELS), FixedScatterers.__name__]))
    free = (PACKAGE / "scattering", PACKAGE / "study")
    files = [file for file in PACKAGE.rglob("*.py") if not any(file.is_relative_to(folder) for folder in free)]
    assert not [file.name for file in files if names.search(file.read_text(encoding="utf-8"))] and len(files) > 100


@pytest.mark.parametrize("model", MODELS)
def test_models_describe_bodies_before_they_are_built(model: Any) -> None:
    """Descriptions name how often echoes are computed, and a box of 9 m has a maximum above 1 m^2."""
    made = scene([{**BOX, "scattering": "optics" if model is PhysicalOptics else "diffuse"}])
    body = made.bodies[0] if model is not DeclaredScattering else scene([{**BOX, "rcs_dbsm": 3}]).bodies[0]
    sampler = "sobol" if model is RaySampledSurfaces else "scatterers"
    fidelity = PRESETS["balanced"]
    described = model.description(body, Conditions.of_scene(made, replace(fidelity, sampler=sampler)), "computed once")
    assert "computed once" in described
    assert model.max_rcs(body, made.radar, fidelity) > 1.0


# scatterer_set: A set of bodies of several models: echoes by rising body, whatever order the models have.
def mixed() -> rs.Scene:
    """Models in turn, at bearings of their own."""
    kinds = [{"material": "wood"}, {"scattering": "optics"}, {"rcs_dbsm": 5}, {"material": "wood"}, {"scattering": "optics"}]
    bodies = [{**BOX, "name": f"b{k}", "position_m": [400 * k - 800, 500, 0], **kind} for k, kind in enumerate(kinds)]
    return scene([*bodies, point("p", -700, 300)])


def built(made: rs.Scene, keys: list[int], sampler: str = "scatterers") -> ScattererSet:
    return build_scatterers([made.bodies[k] for k in keys], keys, context(made, sampler=sampler))


def echoes(made: rs.Scene, scatterers: ScattererSet) -> BodyEchoes:
    return scatterers.echoes(made.antenna(0.0)[0], instant(made))


def test_echoes_are_those_of_each_body_alone_in_order() -> None:
    """Indices count the set's bodies, not the scene's: body 2 is left out."""
    made, keys = mixed(), [0, 1, 3, 4, 5]
    whole = echoes(made, built(made, keys))
    assert (np.diff(whole.body) >= 0).all() and set(whole.body.tolist()) == {0, 1, 2, 3, 4}
    for b, key in enumerate(keys):
        alone = echoes(made, built(made, [key]))
        np.testing.assert_array_equal(whole.position[whole.body == b], alone.position)
        np.testing.assert_array_equal(whole.amplitude[whole.body == b], alone.amplitude)


def test_models_share_their_bodies_and_count_their_scatterers() -> None:
    made, keys = mixed(), [0, 1, 2, 3, 4, 5]
    scatterers = built(made, keys)
    assert len(scatterers) == 6 and [model.key.tolist() for model in scatterers.models] == [[0, 3], [1, 4], [2, 5]]
    counts = scatterers.scatterers
    assert counts[[1, 4]].tolist() == [0, 0] and counts[5] == 1 and (counts[[0, 3]] >= 48).all()
    assert built(made, keys, "sobol").scatterers[[0, 3]].tolist() == [0, 0]


def test_an_empty_set_has_no_echoes() -> None:
    made = mixed()
    none = built(made, [])
    assert len(none) == 0 and len(echoes(made, none)) == 0 and none.scatterers.shape == (0,)


def test_models_by_aspect_are_apart_from_the_steady_ones() -> None:
    """The steady part keeps the indices of the whole set."""
    made, keys = mixed(), [0, 1, 2, 3, 4, 5]
    scatterers = built(made, keys)
    assert [model.key.tolist() for model in scatterers.aspect_models] == [[1, 4]]
    assert set(echoes(made, scatterers.steady).body.tolist()) == {0, 2, 3, 5} and len(scatterers.steady) == 6


# resting_points: points of land by cells of the map, against all points one by one.
SLAB = {"shape": "box", "length_m": 600, "width_m": 500, "height_m": 3, "material": "land", "heading_deg": 30}


@pytest.mark.parametrize("antenna", [(0.0, 0.0), (-3000.0, 450.0), (700.0, 5000.0)])
def test_cells_miss_no_point_of_a_wedge(antenna: tuple[float, float]) -> None:
    """And of the points that they hold a tenth at most lies farther from the wedge than the diagonal of a cell, 181 m."""
    rng = np.random.default_rng(7)
    position = np.column_stack([rng.uniform(-4000, 4000, (20_000, 2)), np.zeros(20_000)])
    cells, order = MapCells.of(position)
    assert np.array_equal(np.sort(order), np.arange(20_000))
    position = position[order]
    for middle in (0.1, 2.0, 4.5):
        wedge = BearingWedge(np.array([*antenna, 15.0]), middle, 0.1, 300.0)
        chosen = spans(*cells.within(wedge))[1]
        assert len(np.unique(chosen)) == len(chosen)
        assert set(np.flatnonzero(wedge.contains(position)).tolist()) <= set(chosen.tolist())
        assert wedge.contains(position[chosen], 182.0).all()


def test_points_at_rest_are_those_of_the_model() -> None:
    """Sum of the strengths squared: gamma times the area of the box, 2 x (600 x 500 + 3 x 1100) m^2 or what lies over the sea."""
    made = scene([{**SLAB, "name": "a", "position_m": [900, 0, 0]}, {**SLAB, "name": "b", "position_m": [-900, 0, 0]}])
    model = build(DiffuseScattering, made)
    points = model.resting_points()
    assert len(points) == model.scatterers.sum() and np.bincount(points.body).tolist() == model.scatterers.tolist()
    area = 2 * (600 * 500 + 3 * 1100)
    energy = np.sum(np.abs(points.strength) ** 2, where=points.body == 1)
    assert energy == pytest.approx(made.bodies[1].material.gamma * area, rel=0.01)  # each triangle to within one point
    away = points.position - np.where(points.body == 0, 900.0, -900.0)[:, None] * [1.0, 0.0, 0.0]
    assert np.linalg.norm(away, axis=1).max() < 391.0  # half the diagonal of the box


def test_joined_sets_have_the_bodies_of_both_in_order() -> None:
    made = scene([{**SLAB, "name": f"b{k}", "position_m": [900 * k, 500, 0]} for k in range(3)])
    outer, inner = (build_scatterers([made.bodies[k] for k in keys], keys, context(made)) for keys in ([0, 2], [1]))
    both, one = inner.joined(outer), build_scatterers(made.bodies, [0, 1, 2], context(made))
    assert [body.name for body in both.bodies] == ["b0", "b1", "b2"] and both.key.tolist() == [0, 1, 2]
    assert both.scatterers.tolist() == one.scatterers.tolist()


# declared_scattering: declared cross-sections: shared by what is visible, whole in a sector, and of small meshes.
def test_visible_scatterers_share_a_declared_cross_section() -> None:
    """A hull half behind a wall still has all of its 20 dBsm, on the half that is seen; the key of the wall lies between. Energy
    relative to the middle's range: within what 30 m do to R^-4 at 600 m, 20 %, and neighbours overlap by 4 %."""
    hull = {"name": "h", "shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "position_m": [0, 600, 0],
            "heading_deg": 90, "rcs_dbsm": 20}  # fmt: skip
    wall = {"name": "w", "shape": "plate", "width_m": 30, "height_m": 60, "position_m": [15, 300, 20], "rcs_dbsm": 0,
            "heading_deg": 180}  # fmt: skip
    made = scene([hull, wall], environment=FLAT)
    model, antenna = build(DeclaredScattering, made), made.antenna(0.0)[0]
    echoes = model.echoes(antenna, instant(made))
    shares = np.bincount(echoes.body, np.abs(echoes.amplitude) ** 2, minlength=2)
    assert shares == pytest.approx([100.0, 1.0], rel=0.24)
    position = map_from_bodies(
        echoes.position, echoes.body, *(np.array([[0, 600, 0], [15, 300, 20.0]]), np.deg2rad([90, 180]))
    )
    assert position[echoes.body == 0, 0].max() < 0.0


def test_a_small_declared_mesh_stands_for_its_height_above_the_sea() -> None:
    """A buoy within a cell is one echo in the middle of what is above the water, as high as that."""
    buoy = {"name": "b", "shape": "cylinder", "radius_m": 0.5, "height_m": 4, "position_m": [0, 500, -1], "rcs_dbsm": 0}
    made = scene([buoy], environment=FLAT)
    (echo,) = [build(DeclaredScattering, made).echoes(made.antenna(0.0)[0], instant(made))]
    assert len(echo) == 1 and echo.height_span[0] == pytest.approx(3.0) and echo.position[0, 2] == pytest.approx(2.5)


@pytest.mark.parametrize(
    "model, more, seen", [(DiffuseScattering, {"material": "wood"}, 0), (DeclaredScattering, {"rcs_dbsm": 1}, 1)]
)
def test_a_declared_body_counts_where_its_echoes_may_lie_beside_its_scatterers(
    model: type[FixedScatterers], more: dict[str, Any], seen: int
) -> None:
    """A quay 0.6747 rad to each side, and sectors that begin half of a spacing of cells beside it, and two spacings."""
    quay = {"name": "q", "shape": "box", "length_m": 10, "width_m": 800, "height_m": 20, "position_m": [0, 500, 0]}
    made, antenna = scene([{**quay, **more}], environment=FLAT), np.array([0.0, 0.0, 15.0])
    source, begin, spacing = build(model, made), np.arctan2(400, 495), cell_spacing(made.radar).azimuth
    for off, count in ((0.5, seen), (2.0, 0)):
        sector = BearingWedge(antenna, begin + off * spacing + 0.3, 0.3, 1.0)
        assert bool(len(source.echoes(antenna, instant(made, wedge=sector)))) == count


# model: what models are told of a scene, and what they answer of runs: by hand.
FAR_BOX = {"name": "b", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9, "position_m": [0, 3000, 0]}
PASSING = BodyRun(nearest=100.0, approach=110.0, time=60.0, turn=0.1, radial=10.0, sea_turn=0.01, start=3000.0)
SCATTERINGS: dict[str, dict[str, Any]] = {
    "diffuse": {"scattering": "diffuse"},
    "rcs": {"rcs_dbsm": 3},
    "optics": {"scattering": "optics"},
}


def conditions(scatterers: int | None = None, sampler: str = "scatterers", **body: Any) -> Conditions:
    made = scene([{**FAR_BOX, **body}], environment={"multipath": True})
    return Conditions.of_scene(made, replace(PRESETS["balanced"], sampler=sampler), scatterers)


def test_the_antenna_is_where_it_is_at_time_0() -> None:
    made = scene([FAR_BOX], own_ship={"position_m": [40, 50], "speed_kn": 20, "course_deg": 90})
    told = Conditions.of_scene(made, PRESETS["balanced"])
    assert told.antenna.tolist() == [40.0, 50.0, made.radar.height] and told.scatterers is None


def test_a_surface_that_comes_nearer_has_fewer_scatterers_in_a_cell() -> None:
    """From 3000 m to 110 m: cells are 27 times narrower, the errors of the root of 27 times fewer add in squares."""
    body, told = scene([FAR_BOX | SCATTERINGS["diffuse"]]).bodies[0], conditions(**SCATTERINGS["diffuse"])
    width = max(told.radar.beamwidth * 110.0, told.radar.range_step)
    there = density_db(4.0 * width / (told.radar.beamwidth * 3000.0))
    power, (remark,) = DiffuseScattering.run_error(body, told, PASSING)
    assert math.hypot(power, density_db(4.0)) == pytest.approx(there, rel=1e-12) and "at its closest, 100 m" in remark
    assert DiffuseScattering.run_error(body, told, PASSING._replace(approach=3000.0)) == RunError()


@pytest.mark.parametrize(
    ("shape", "bounces"),
    [
        ("box", "one surface, as none faces another; 6 pieces, some 0.035 ms an aspect"),
        ("dihedral", "up to 3 bounces, as parts face each other; 4 pieces, some 0.072 ms an aspect"),
    ],
)
def test_bounces_are_told_of_metal_that_faces_itself_alone(shape: str, bounces: str) -> None:
    """All of a closed box rises behind its sides, where no wave comes; a corner has bounces, and their error."""
    table = {"name": "b", "shape": shape, "width_m": 9, "height_m": 9, "scattering": "optics"}
    body = scene([table | ({"length_m": 9} if shape == "box" else {})]).bodies[0]
    told = conditions(**SCATTERINGS["optics"])
    assert bounces in PhysicalOptics.description(body, told, "computed once")
    assert PhysicalOptics.error_db(body, told) == {"box": FACETS_DB, "dihedral": REBOUNCES_DB}[shape]


@pytest.mark.parametrize("name", SCATTERINGS)
def test_errors_of_sampling_are_those_of_surfaces_that_are_sampled(name: str) -> None:
    """Declared cross-sections are shared exactly, but for the lobes of sea reflection; metal has no scatterers."""
    body = scene([FAR_BOX | SCATTERINGS[name]]).bodies[0]
    model = scattering_model(body)
    expected = {
        "diffuse": (surface_db(60, False), surface_db(60, True)),
        "rcs": (0.0, surface_db(60, True)),
        "optics": (0.0, 0.0),
    }
    assert tuple(model.sampling_db(60, multipath) for multipath in (False, True)) == expected[name]


def test_rays_predict_nothing() -> None:
    body = scene([FAR_BOX | SCATTERINGS["diffuse"]]).bodies[0]
    model, told = scattering_model(body, "sobol"), conditions(sampler="sobol", **SCATTERINGS["diffuse"])
    assert model.error_db(body, told) is None and model.run_error(body, told, PASSING) == RunError()
    assert model.mesh_remarks(body, told, 100.0) == [] and model.coherence_at(body, told.radar, 100.0) == 0.0


def test_metal_is_summed_over_the_same_size_before_and_after_it_is_built() -> None:
    """By the class for the nearest part, by the model for the middle."""
    made = scene([FAR_BOX | SCATTERINGS["optics"]])
    by_model = build(PhysicalOptics, made).coherence(0, 500.0 + made.bodies[0].radius)
    assert PhysicalOptics.coherence_at(made.bodies[0], made.radar, 500.0) == by_model > 0.0
