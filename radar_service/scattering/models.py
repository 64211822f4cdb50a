"""Which scattering model each body has. Only this module decides it."""

from radar_service.propagation.diffraction import diffraction_height
from radar_service.scattering.declared_scattering import DeclaredScattering
from radar_service.scattering.fixed_scatterers import DiffuseScattering
from radar_service.scattering.model import ScatteringModel
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.scattering.rays import RaySampledSurfaces
from radar_service.world.body import Body
from radar_service.world.scene import Scene

SCATTERING_MODELS: dict[str, type[ScatteringModel]] = {
    "rcs": DeclaredScattering,
    "diffuse": DiffuseScattering,
    "optics": PhysicalOptics,
}


def scattering_model(body: Body, sampler: str = "scatterers") -> type[ScatteringModel]:
    """The model of a body. sampler: of the fidelity; by any other than "scatterers", rays sample diffuse surfaces."""
    name = "rcs" if body.mesh is None or body.rcs is not None else body.scattering
    if name == "diffuse" and sampler != "scatterers":
        return RaySampledSurfaces
    return SCATTERING_MODELS[name]


def height_over_horizon(body: Body, scene: Scene, sampler: str = "scatterers") -> float:
    """Height [m] up to which parts of a body have echoes beyond the horizon; 0 where its model has none."""
    return diffraction_height(scene.radar, scene.environment) if scattering_model(body, sampler).diffracts else 0.0
