"""Ray tubes from facet to facet of a body: where each one hits, and with which field.

A tube is a triangle throughout: a flat reflector maps corners to corners along parallel lines, so its footprint on the next
surface is integrated in closed form too. Rays at its centre and near its corners are traced, and it is divided where they hit
different planes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.scattering.physical_optics.facet_integral import specular_reflection
from radar_service.scattering.physical_optics.facets import halves
from radar_service.scattering.physical_optics.lit_facets import LitFacets, Planes
from radar_service.trace.embree import TriangleScene
from radar_service.types import Floats, Indices

# m; a bounce starts this far off its surface (docs/reference-values.md#embree: 0.1 mm still hits itself in 7 % of cases)
OFFSET = 1e-3
OFFSET_RELATIVE = 1e-6  # of the body's radius: ten times float32 rounding of its coordinates
MAX_HALVINGS = 4
MAX_DIVIDED = 3_000  # halves of tubes at once
SAMPLES = 0.02 / 3.0 + 0.98 * np.array([[1 / 3] * 3, [1, 0, 0], [0, 1, 0], [0, 0, 1]])  # centre and corners, off the edges
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

    @classmethod
    def joined(cls, parts: "Sequence[RayTubes]") -> "RayTubes":
        """The tubes of several parts."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__dataclass_fields__))

    def chosen(self, which: Indices) -> "RayTubes":
        """The tubes `which`."""
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


def hits(tubes: RayTubes, planes: Planes, scene: TriangleScene, bounces: int, smallest: Floats) -> Iterator[RayTubes]:
    """The tubes after each reflection at a surface, up to `bounces` surfaces in all, the first one counted.

    smallest: (F,) length of edges below which tubes on each triangle of the mesh are not divided [m].
    """
    for _ in range(1, bounces):
        tubes = _reflected(tubes, planes, scene, smallest)
        if not len(tubes):
            return
        yield tubes


def _reflected(tubes: RayTubes, planes: Planes, scene: TriangleScene, smallest: Floats) -> RayTubes:
    """The tubes that hit another surface of the body after reflection at this one, divided where parts of one hit different
    planes."""
    tubes = tubes.chosen(_may_hit_more(tubes, planes))
    done = []
    for level in range(MAX_HALVINGS + 1):
        tube, hit = _sampled(tubes, planes, scene)
        plane = np.where(hit >= 0, planes.number[hit], -1)
        longest = np.sqrt(((tubes.corners - np.roll(tubes.corners, 1, axis=1)) ** 2).sum(axis=2).max(axis=1, initial=0.0))
        mixed = (plane != plane[0]).any(axis=0) & (longest > smallest[tubes.triangle])
        if level == MAX_HALVINGS or 2 * np.count_nonzero(mixed) > MAX_DIVIDED:
            mixed[:] = False
        hitting = np.flatnonzero((hit[0] >= 0) & ~mixed)
        done.append(replace(tube.chosen(hitting), triangle=hit[0, hitting]))
        divided = np.flatnonzero(mixed)
        if not len(divided):
            break
        tubes = halved(tubes.chosen(divided))
    return _projected(RayTubes.joined(done), planes)


def _sampled(tubes: RayTubes, planes: Planes, scene: TriangleScene) -> tuple[RayTubes, Indices]:
    """The tubes as a surface reflects them, and the triangles (S, M) that their samples hit, the first one that of the centre."""
    direction, field = specular_reflection(tubes.direction, tubes.field, tubes.normal)
    offset = OFFSET + OFFSET_RELATIVE * scene.radius
    begin = np.einsum("sc,mcx->smx", SAMPLES, tubes.corners) + offset * tubes.normal
    hit = scene.first_hit(begin.reshape(-1, 3), np.tile(direction, (len(SAMPLES), 1))).reshape(len(SAMPLES), -1)
    return replace(tubes, direction=direction, field=field), hit


def halved(tubes: RayTubes) -> RayTubes:
    """Both halves of each tube (2 M,), where it is about to be reflected."""
    twice, corners = tubes.chosen(np.tile(np.arange(len(tubes)), 2)), halves(tubes.corners)
    centre = (corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3.0
    offset = centre - twice.centre
    along = np.einsum("ij,ij->i", offset, twice.direction)
    across = offset - along[:, None] * twice.direction
    longer = along + np.einsum("ij,ij->i", across, across) / (2.0 * twice.length)
    direction = twice.direction + across / twice.length[:, None]
    direction /= np.sqrt(np.einsum("ij,ij->i", direction, direction))[:, None]
    begin, length = twice.begin + offset, twice.length + longer
    return replace(twice, corners=corners, centre=centre, direction=direction, begin=begin, length=length)


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
