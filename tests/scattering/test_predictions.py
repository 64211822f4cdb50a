"""What models are told of a scene, and what they answer of runs: by hand."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.records.fidelity import PRESETS
from radar_service.scattering.fixed_scatterers import DiffuseScattering
from radar_service.scattering.models import scattering_model
from radar_service.scattering.physical_optics.model import FACETS_DB, REBOUNCES_DB, PhysicalOptics
from radar_service.scattering.predictions import BodyRun, Conditions, RunError
from radar_service.scattering.surface_sampling import density_db, surface_db
from tests.scattering.test_fixed_scatterers import context
from tests.scenes import scene

BOX = {"name": "b", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9, "position_m": [0, 3000, 0]}
PASSING = BodyRun(nearest=100.0, approach=110.0, time=60.0, turn=0.1, radial=10.0, sea_turn=0.01, start=3000.0)
KINDS: dict[str, dict[str, Any]] = {
    "diffuse": {"scattering": "diffuse"},
    "rcs": {"rcs_dbsm": 3},
    "optics": {"scattering": "optics"},
}


def conditions(scatterers: int | None = None, sampler: str = "scatterers", **body: Any) -> Conditions:
    made = scene([{**BOX, **body}], environment={"multipath": True})
    return Conditions.of_scene(made, replace(PRESETS["balanced"], sampler=sampler), scatterers)


def test_the_antenna_is_where_it_is_at_time_0() -> None:
    made = scene([BOX], own_ship={"position_m": [40, 50], "speed_kn": 20, "course_deg": 90})
    told = Conditions.of_scene(made, PRESETS["balanced"])
    assert told.antenna.tolist() == [40.0, 50.0, made.radar.height] and told.scatterers is None


def test_a_surface_that_comes_nearer_has_fewer_scatterers_in_a_cell() -> None:
    """From 3000 m to 110 m: cells are 27 times narrower, the errors of the root of 27 times fewer add in squares."""
    body, told = scene([BOX | KINDS["diffuse"]]).bodies[0], conditions(**KINDS["diffuse"])
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
    told = conditions(**KINDS["optics"])
    assert bounces in PhysicalOptics.description(body, told, "computed once")
    assert PhysicalOptics.error_db(body, told) == {"box": FACETS_DB, "dihedral": REBOUNCES_DB}[shape]


@pytest.mark.parametrize("name", KINDS)
def test_errors_of_sampling_are_those_of_surfaces_that_are_sampled(name: str) -> None:
    """Declared cross-sections are shared exactly, but for the lobes of sea reflection; metal has no scatterers."""
    body = scene([BOX | KINDS[name]]).bodies[0]
    model = scattering_model(body)
    expected = {
        "diffuse": (surface_db(60, False), surface_db(60, True)),
        "rcs": (0.0, surface_db(60, True)),
        "optics": (0.0, 0.0),
    }
    assert tuple(model.sampling_db(60, multipath) for multipath in (False, True)) == expected[name]


def test_rays_predict_nothing() -> None:
    body = scene([BOX | KINDS["diffuse"]]).bodies[0]
    model, told = scattering_model(body, "sobol"), conditions(sampler="sobol", **KINDS["diffuse"])
    assert model.error_db(body, told) is None and model.run_error(body, told, PASSING) == RunError()
    assert model.mesh_remarks(body, told, 100.0) == [] and model.coherence_at(body, told.radar, 100.0) == 0.0


def test_metal_is_summed_over_the_same_size_before_and_after_it_is_built() -> None:
    """By the class for the nearest part, by the model for the middle."""
    made = scene([BOX | KINDS["optics"]])
    built = PhysicalOptics.build(made.bodies, np.arange(1), context(made))
    at = 500.0
    assert (
        PhysicalOptics.coherence_at(made.bodies[0], made.radar, at) == built.coherence(0, at + made.bodies[0].radius) > 0.0
    )
