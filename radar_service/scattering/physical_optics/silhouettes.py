"""Silhouettes of triangles as the antenna sees them: where their shadows may end."""

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Floats


def silhouettes(corners: Floats) -> tuple[Floats, Floats]:
    """Planes (E, 4, 3) and offsets (E, 4) [m] of edges of triangles (T, 3, 3) about the antenna at which a shadow may end: those
    from which all triangles lie on one side.

    The first plane leads through the antenna and the edge. The others bound what is behind the edge: they stand across the
    first one at both ends, and across the rays; their normals point to it.
    """
    planes, offsets = np.empty((3 * len(corners), 4, 3)), np.empty((3 * len(corners), 4))
    count = KERNELS.silhouettes(len(corners), np.ascontiguousarray(corners), planes, offsets)
    return planes[:count], offsets[:count]
