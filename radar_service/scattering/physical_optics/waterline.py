"""Cutting triangles at a level: what lies below the water neither scatters nor casts an echo."""

import numpy as np

from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.physical_optics.triangle_cuts import cut


def above_water(corners: Floats, level: float) -> tuple[Floats, Indices]:
    """The parts of triangles (M, 3, 3) that rise above `level` [m], and the triangle that each comes from (N,).

    Triangles that lie above as a whole come first, as they are. Others are cut exactly along the level.
    """
    height = corners[:, :, 2] - level
    if not (height < 0.0).any():
        return corners, np.arange(len(corners))
    return cut(corners, height)[0]
