"""Ray tubes from facet to facet of a body: where each one hits, and with which field.

A tube is a triangle throughout: a flat reflector maps corners to corners along parallel lines, so its footprint on the next
surface is integrated in closed form too. Only its middle ray is traced to the next triangle.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from radar_service.scattering.physical_optics.facet_integral import specular_reflection
from radar_service.scattering.physical_optics.lit_facets import LitFacets, Planes
from radar_service.trace.embree import TriangleScene
from radar_service.types import Floats, Indices

# m; a bounce starts this far off its surface (docs/reference-values.md#embree: 0.1 mm still hits itself in 7 % of cases)
OFFSET = 1e-3
OFFSET_RELATIVE = 1e-6  # of the body's radius: ten times float32 rounding of its coordinates
GRAZING = 0.01  # cosine below which a footprint is over a hundred tubes long, and its middle ray no longer represents it


@dataclass(frozen=True)
class RayTubes:
    """Ray tubes (M,) where they hit a surface.

    corners: (M, 3, 3) of the footprint [m].
    centre: (M, 3) of the footprint [m].
    normal: (M, 3), of unit length, on the lit side.
    triangle: (M,) of the mesh.
    direction: (M, 3) of travel, of unit length.
    field: (M, 3) that arrives, over that at the first surface.
    begin: (M, 3) centre of the first footprint [m].
    launched: (M, 3) direction of travel before it.
    length: (M,) of the way from the antenna to here [m].
    share: (M,) of the tube that the leg from the antenna reaches.
    cell: (M,) size of the cell in which its field is summed [m].
    """

    corners: Floats
    centre: Floats
    normal: Floats
    triangle: Indices
    direction: Floats
    field: Floats
    begin: Floats
    launched: Floats
    length: Floats
    share: Floats
    cell: Floats

    def __len__(self) -> int:
        return len(self.length)

    def chosen(self, which: Indices) -> "RayTubes":
        """The tubes `which`, rising indices."""
        if len(which) == len(self):
            return self  # all of them
        return RayTubes(*(getattr(self, name).take(which, axis=0) for name in self.__dataclass_fields__))


def launched_tubes(facets: LitFacets, leg: int, polarization: str, planes: Planes) -> RayTubes:
    """The tubes at the facets that a leg lights, where anything of the body is there to be hit next."""
    side = facets.side[:, leg]
    rebounces = planes.may_rebounce[facets.triangle, np.where(side > 0, 0, 1)]
    which = np.flatnonzero((side != 0) & (facets.share[:, leg] > 0.0) & rebounces)
    rays, centre = facets.rays[leg].chosen(which), facets.centre.take(which, axis=0)
    return RayTubes(
        facets.corners.take(which, axis=0), centre, facets.normal[which] * side[which, None], facets.triangle[which],
        rays.direction, rays.polarization(polarization), centre, rays.direction, rays.length,
        facets.share[which, leg], facets.cell[which],
    )  # fmt: skip


def hits(tubes: RayTubes, planes: Planes, scene: TriangleScene, bounces: int) -> Iterator[RayTubes]:
    """The tubes after each reflection at a surface, up to `bounces` surfaces in all, the first one counted."""
    for _ in range(1, bounces):
        tubes = _reflected(tubes, planes, scene)
        if not len(tubes):
            return
        yield tubes


def _reflected(tubes: RayTubes, planes: Planes, scene: TriangleScene) -> RayTubes:
    """The tubes that hit another surface of the body after reflection at this one."""
    tubes = tubes.chosen(_may_hit_more(tubes, planes))
    direction, field = specular_reflection(tubes.direction, tubes.field, tubes.normal)
    offset = OFFSET + OFFSET_RELATIVE * scene.radius
    hit = scene.first_hit(tubes.centre + offset * tubes.normal, direction)
    hitting = np.flatnonzero(hit >= 0)
    tubes = replace(tubes.chosen(hitting), direction=direction[hitting], field=field[hitting], triangle=hit[hitting])
    return _projected(tubes, planes)


def _may_hit_more(tubes: RayTubes, planes: Planes) -> Indices:
    front = np.einsum("ij,ij->i", tubes.normal, planes.normal.take(tubes.triangle, axis=0)) > 0.0
    return np.flatnonzero(planes.may_rebounce[tubes.triangle, np.where(front, 0, 1)])


def _projected(tubes: RayTubes, planes: Planes) -> RayTubes:
    """Tubes projected along their direction onto the plane of `triangle`, without those that graze it or lie behind it."""
    point, normal = planes.point.take(tubes.triangle, axis=0), planes.normal.take(tubes.triangle, axis=0)
    facing = np.einsum("ij,ij->i", normal, tubes.direction)
    normal = np.where(facing[:, None] > 0.0, -normal, normal)
    facing = -np.abs(facing)
    steep = np.flatnonzero(facing < -GRAZING)
    tubes, normal, facing = tubes.chosen(steep), normal[steep], facing[steep]
    height = np.einsum("mij,mj->mi", tubes.corners - point[steep, None, :], normal)
    travel = height / -facing[:, None]
    corners = tubes.corners + travel[:, :, None] * tubes.direction[:, None, :]
    middle = (travel[:, 0] + travel[:, 1] + travel[:, 2]) / 3.0
    centre = tubes.centre + middle[:, None] * tubes.direction
    projected = replace(tubes, corners=corners, centre=centre, normal=normal, length=tubes.length + middle)
    return projected.chosen(np.flatnonzero(middle > 0.0))
