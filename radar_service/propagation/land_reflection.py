"""Reflection by land, beside the direct ray: where the ground before a target is land, that land reflects in place of the sea.

The reflection is that of a plane as high as the ground at the point of reflection: Fresnel's coefficient of its material, and the
roughness factor exp(-8 (pi s sin(psi) / lambda)^2) with its rms height s (Barton, Radar Equations for Modern Radar, 2013, ch. 8).
Vegetation reflects nothing, and diffuse land takes nothing from its own landmass: its published sigma0 contains that.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Floats, Indices
from radar_service.propagation.multipath import Site, TwoRays, reflection_distance
from radar_service.propagation.sea_surface import ament
from radar_service.trace import LandMask, OcclusionScene
from radar_service.world import GROUND_ROUGHNESS, MATERIALS, permittivity

# by the number of a material in a mask, from that of water on; what reflects nothing has the permittivity of air
ROUGHNESS = np.array([0.0, *(GROUND_ROUGHNESS.get(name, 0.0) for name in MATERIALS)])
PERMITTIVITY = np.array([1.0, *(permittivity(name) if name in GROUND_ROUGHNESS else 1.0 for name in MATERIALS)])
SUNK = 0.01  # m: what lies lower below the ground before it has no reflection there
ABOVE_LAND = 2e-3  # m over the mask, at which rays turn: its heights are rounded, and land must not hide itself
_TINY = 1e-12  # m: avoids 0 / 0 for a target at the foot of the antenna


class LandBefore(NamedTuple):
    """The land that may lie before targets, which are parts of bodies.

    scene: all bodies.
    antenna: (3,) or (..., 3) on the map [m].
    offset: (..., 3) of the targets from it [m].
    body: (E,) index of each one's body in the scene; None: they are no diffuse land.
    """

    scene: OcclusionScene
    antenna: Floats
    offset: Floats
    body: Indices | None = None

    @property
    def site(self) -> Site:
        """Distances and heights of the targets (...,), and of the antenna [m]."""
        east, north, up = np.moveaxis(self.offset, -1, 0)
        return np.hypot(east, north), up + self.antenna[..., 2], self.antenna[..., 2]

    def cells(self, mask: LandMask, share: Floats, which: tuple[Indices, ...] = ()) -> Indices:
        """Cells of a mask after shares of the ways to all targets, or to targets `which`."""
        antenna = np.broadcast_to(self.antenna, self.offset.shape)
        return mask.at(*(antenna[..., k][which] + share * self.offset[..., k][which] for k in (0, 1)))


def over_land(
    rays: TwoRays, land: LandBefore, site: Site, tilt_error: Floats | float, earth_radius: float,
    rays_at: Callable[..., TwoRays],
) -> TwoRays:  # fmt: skip
    """The two rays to targets whose rays over the sea are given: by land where their point of reflection lies on land.

    rays: of any shape, changed in place; site: of the targets, broadcast; tilt_error: of each, or of all [rad]; earth_radius: ae
    [m]; rays_at: as `two_rays`, takes another site, its error of tilt, and what reflects there.
    """
    mask, shape = land.scene.land, rays.gain.shape
    if mask is None:
        return rays
    cell = land.cells(mask, rays.geometry.reflection / np.maximum(site[0], _TINY))
    which = np.nonzero(mask.material.take(cell))
    if not len(which[0]):
        return rays
    rays.ratio[which], cell = 0.0, cell[which]
    if land.body is not None:
        other = mask.landmass.take(land.cells(mask, np.ones(1), which)) != mask.landmass.take(cell)
        left = other | ~mask.diffuse[np.broadcast_to(land.body, shape)[which]]
        which, cell = tuple(index[left] for index in which), cell[left]
    if not len(cell):
        return rays
    distance, height, antenna, tilt = (np.broadcast_to(values, shape) for values in (*site, tilt_error))
    d, h, a = distance[which], height[which], antenna[which]
    plane = mask.height.take(cell).astype(np.float64)
    point = reflection_distance(d, np.maximum(h - plane, 0.0), np.maximum(a - plane, _TINY), earth_radius)
    cell = land.cells(mask, point / np.maximum(d, _TINY), which)
    plane = mask.height.take(cell).astype(np.float64)
    kind = mask.material.take(cell)
    on = (PERMITTIVITY[kind] > 1.0) & (a > plane) & (h > plane - SUNK)
    which, plane, kind = tuple(index[on] for index in which), plane[on], kind[on]
    surface = {"permittivity": PERMITTIVITY[kind], "wave_height": ROUGHNESS[kind], "roughness": ament}
    over = rays_at(d[on], h[on] - plane, a[on] - plane, tilt[which], **surface)
    for sea, ground in zip(rays.geometry, over.geometry, strict=True):
        sea[which] = ground
    rays.ratio[which] = over.ratio
    level = np.zeros(shape)
    level[which] = plane
    return rays._replace(level=level)
