"""Which scattering model each body has. Only this module decides it.

A model is imported when it is first asked for: scene files know the names, and a server that starts needs no more.
"""

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from radar_service.scattering.model import ScatteringModel
    from radar_service.world.body import Body
    from radar_service.world.scene import Scene

SCATTERING_MODELS = {  # by the name in scene files: module and class in this room
    "rcs": "declared_scattering:DeclaredScattering",
    "diffuse": "fixed_scatterers:DiffuseScattering",
    "optics": "physical_optics.model:PhysicalOptics",
}
RAYS = "rays:RaySampledSurfaces"
REFLECTORS = "reflectors:ReflectorScattering"


@cache
def model_at(place: str) -> "type[ScatteringModel]":
    """The model at a place of SCATTERING_MODELS."""
    module, _, name = place.partition(":")
    return cast("type[ScatteringModel]", getattr(import_module(f"radar_service.scattering.{module}"), name))


def scattering_model(body: "Body", sampler: str = "scatterers") -> "type[ScatteringModel]":
    """The model of a body. sampler: of the fidelity; by any other than "scatterers", rays sample diffuse surfaces."""
    if body.reflector is not None:
        return model_at(REFLECTORS)
    name = "rcs" if body.mesh is None or body.rcs is not None else body.scattering
    return model_at(RAYS if name == "diffuse" and sampler != "scatterers" else SCATTERING_MODELS[name])


def height_over_horizon(body: "Body", scene: "Scene", sampler: str = "scatterers") -> float:
    """Height [m] up to which parts of a body have echoes beyond the horizon; 0 where its model has none."""
    from radar_service.propagation.diffraction import diffraction_height  # here: it needs scipy

    return diffraction_height(scene.radar, scene.environment) if scattering_model(body, sampler).diffracts else 0.0
