"""The registry: each body has the model that its scene file names."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import radar_service
from radar_service.plug_ins import names as part_names
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.declared_scattering import DeclaredScattering
from radar_service.scattering.fixed_scatterers import DiffuseScattering, FixedScatterers
from radar_service.scattering.models import model_named, scattering_model
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.scattering.predictions import Conditions
from radar_service.scattering.rays import RaySampledSurfaces
from radar_service.world.error import SceneError
from radar_service.world.materials import MATERIALS
from tests.scenes import point, scene

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
