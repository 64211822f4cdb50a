"""Scattering models: fixed scatterers, sampled rays, physical optics of metal, Swerling fluctuation."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.scattering.model import (
        ALL_PATHS, DIRECT, AspectModel, BearingWedge, BodyEchoes, Caster, Instant, ScatteringContext
    )  # fmt: skip
    from radar_service.scattering.models import height_over_horizon, model_named, scattering_model
    from radar_service.scattering.physical_optics.body_legs import BodyLeg
    from radar_service.scattering.physical_optics.model import PhysicalOptics
    from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces
    from radar_service.scattering.physical_optics.plane_echoes import Longest, PlaneOptics, Wave
    from radar_service.scattering.physical_optics.plating import SPREAD, upright_warnings
    from radar_service.scattering.model import NEAREST, BodyRun, Conditions
    from radar_service.scattering.rays import RayCaster, RaySampledSurfaces
    from radar_service.scattering.reflector_patterns import highest_rcs, reflector_text, size_of
    from radar_service.scattering.resting_points import RestingModel, RestingPoints
    from radar_service.scattering.scatterer_set import ScattererSet, build_scatterers
    from radar_service.scattering.surface_sampling import MAX_STRATA, R2, density_db, normals_and_areas, points_in_triangles
    from radar_service.scattering.swerling import Fluctuation, per_azimuth
else:
    __getattr__, __dir__ = lazily(__name__)
