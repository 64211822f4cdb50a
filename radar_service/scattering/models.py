"""Which scattering model each body has. Only this module decides it.

The models are the entry points `radar_service.scattering`, by their names in scene files. A model is imported when it is first
asked for: scene files know the names, and a server that starts needs no more.
"""

from typing import TYPE_CHECKING, cast

from radar_service import plug_ins

if TYPE_CHECKING:
    from radar_service.scattering.model import ScatteringModel
    from radar_service.world import Body, Scene


def model_named(name: str) -> "type[ScatteringModel]":
    """Returns the model of that name in scene files. Raises PlugInError."""
    return cast("type[ScatteringModel]", plug_ins.load("scattering", name))


def scattering_model(body: "Body", sampler: str = "scatterers") -> "type[ScatteringModel]":
    """The model of a body. sampler: of the fidelity; by any other than "scatterers", rays sample diffuse surfaces."""
    if body.reflector is not None:
        from radar_service.scattering.reflectors import ReflectorScattering  # here and below: see above

        return ReflectorScattering
    name = "rcs" if body.mesh is None or body.rcs is not None else body.scattering
    if name != "diffuse" or sampler == "scatterers":
        return model_named(name)
    from radar_service.scattering.rays import RaySampledSurfaces

    return RaySampledSurfaces


def height_over_horizon(body: "Body", scene: "Scene", sampler: str = "scatterers") -> float:
    """Height [m] up to which parts of a body have echoes beyond the horizon; 0 where its model has none."""
    from radar_service.propagation import diffraction_height  # here: it needs scipy

    return diffraction_height(scene.radar, scene.environment) if scattering_model(body, sampler).diffracts else 0.0
