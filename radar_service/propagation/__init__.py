"""From antenna to target: radar equation, multipath, diffraction, sea surface, attenuation."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.propagation.diffraction import MAX_HEIGHT, diffraction_height
    from radar_service.propagation.gas_and_rain import attenuation_amplitude, printed_atmosphere, rain_db_per_km
    from radar_service.propagation.land_reflection import ABOVE_LAND, LandBefore
    from radar_service.propagation.multipath import (
        Site, TwoRays, mean_square_factor, moved_excess, printed_two_ray_factor, reflection_distance, specular_geometry,
        turned_back, two_ray_factor
    )  # fmt: skip
    from radar_service.propagation.radar_equation import (
        attenuation, elevation_gain, local_attenuation, radar_two_rays, received_amplitude, two_way_phase
    )  # fmt: skip
    from radar_service.propagation.sea_surface import ament, miller_brown, rms_wave_height
else:
    __getattr__, __dir__ = lazily(__name__)
