"""The registry: each body has the model that its scene file names."""

from dataclasses import replace
from typing import Any, get_args

import pytest

from radar_service.records.fidelity import PRESETS
from radar_service.scattering.declared_scattering import DeclaredScattering
from radar_service.scattering.fixed_scatterers import DiffuseScattering
from radar_service.scattering.models import SCATTERING_MODELS, scattering_model
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.scattering.rays import RaySampledSurfaces
from radar_service.world.body import Scattering
from tests.scenes import point, scene

BOX = {"name": "b", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9, "position_m": [0, 300, 0]}
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


def test_the_registry_has_every_name_that_a_scene_file_may_give() -> None:
    assert set(SCATTERING_MODELS) == set(get_args(Scattering))


@pytest.mark.parametrize("model", [*SCATTERING_MODELS.values(), RaySampledSurfaces])
def test_models_describe_bodies_before_they_are_built(model: Any) -> None:
    """Descriptions name how often echoes are computed, and a box of 9 m has a maximum above 1 m^2."""
    made = scene([{**BOX, "scattering": "optics" if model is PhysicalOptics else "diffuse"}])
    body = made.bodies[0] if model is not DeclaredScattering else scene([{**BOX, "rcs_dbsm": 3}]).bodies[0]
    sampler = "sobol" if model is RaySampledSurfaces else "scatterers"
    fidelity = PRESETS["balanced"]
    described = model.description(body, made, replace(fidelity, sampler=sampler), "computed once")
    assert "computed once" in described
    assert model.max_rcs(body, made.radar, fidelity) > 1.0
