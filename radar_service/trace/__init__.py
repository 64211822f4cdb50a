"""What rays hit and what hides what: Embree, Moeller-Trumbore, line of sight, ray sampling."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.trace.box_tree import Boxes, interleaved
    from radar_service.trace.embree import TREES, RayCount, TriangleScene
    from radar_service.trace.land_mask import WATER, LandMask
    from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
    from radar_service.trace.moller_trumbore import TriangleList, printed_crossings, watertight_crossings
    from radar_service.trace.occluder import Occluder, beyond_horizon
    from radar_service.trace.ray_sampling import (
        BOX_BEAMWIDTHS, azimuth_offsets, elevation_offsets, full_circle_rays, missed_area_range
    )  # fmt: skip
    from radar_service.trace.ray_target import RayTarget, sea_range
    from radar_service.trace.shadow_sectors import ShadowSectors
    from radar_service.trace.tree_cache import content_key
    from radar_service.trace.triangle_clusters import TriangleClusters, box_corners
else:
    __getattr__, __dir__ = lazily(__name__)
