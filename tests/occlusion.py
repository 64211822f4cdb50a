"""What any body occludes, for tests of what is computed from it."""

from radar_service.numerics.types import Flags, Floats
from radar_service.trace.line_of_sight import OcclusionScene


def occluded(made: OcclusionScene, position: Floats, antenna: Floats, time: float) -> Flags:
    """Which positions (W, 3) on the map a body at rest or a moving one occludes from the antenna (3,) at `time` [s]."""
    return made.occluded_by_resting(position, antenna) | made.occluded_by_moving(position, antenna, time)
