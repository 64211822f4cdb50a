"""Ray tubes from facet to facet of a body: where each one hits, and with which field.

A tube is a triangle throughout: a flat reflector maps corners to corners along parallel lines, so its footprint on the next
surface is integrated in closed form too. Rays at its centre and near its corners are traced, and it is divided where they hit
different planes. Vectors stand by axis, (3, M): numpy works on such columns several times faster than on rows of three.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.facet_integral import specular_reflection
from radar_service.scattering.physical_optics.lit_facets import Planes, Surface
from radar_service.trace.embree import TriangleScene
from radar_service.types import Flags, Floats, Indices

# m; a bounce starts this far off its surface (docs/reference-values.md#embree: 0.1 mm still hits itself in 7 % of cases)
OFFSET = 1e-3
OFFSET_RELATIVE = 1e-6  # of the body's radius: ten times float32 rounding of its coordinates
MAX_HALVINGS = 6
MAX_DIVIDED = 6_000  # halves of tubes at once
INSET = 0.02  # of the way from a corner to the centre: rays start off the edges
LONGEST = 1.5  # times the longest edge that the phase allows a facet: a tube that hits something is divided above it
GRAZING = 0.01  # cosine below which a footprint is over a hundred tubes long, and its middle ray no longer represents it


@dataclass(frozen=True)
class RayTubes:
    """Ray tubes (M,) where they hit a surface.

    corners: (3, 3, M) of the footprint, by corner and axis [m].
    centre: (3, M) of the footprint [m].
    normal: (3, M), of unit length, on the lit side.
    triangle: (M,) of the mesh.
    direction: (3, M) of travel, of unit length.
    field: (3, M) that arrives, over that at the first surface.
    begin: (3, M) centre of the first footprint [m].
    launched: (3, M) direction of travel before it.
    length: (M,) of the way from the antenna to here [m].
    share: (M,) of the tube that the leg from the antenna reaches.
    cell: (M,) size of the cell in which its field is summed [m].
    longest: (M,) edge above which it is divided where it hits something [m].
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
    longest: Floats

    def __len__(self) -> int:
        return len(self.length)

    @classmethod
    def joined(cls, parts: "Sequence[RayTubes]") -> "RayTubes":
        """The tubes of several parts."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, name) for part in parts], axis=-1) for name in cls.__dataclass_fields__))

    def chosen(self, which: Indices) -> "RayTubes":
        """The tubes `which`."""
        return RayTubes(*(getattr(self, name).take(which, axis=-1, mode="clip") for name in self.__dataclass_fields__))


def launched_tubes(surface: Surface, number: int, leg: BodyLeg, polarization: str, planes: Planes) -> RayTubes:
    """The tubes at the triangles that a leg lights, where anything of the body is there to be hit next.

    number: of the leg among those of `surface`.
    """
    side = surface.side[:, number]
    rebounces = planes.may_rebounce[surface.triangle, np.where(side > 0, 0, 1)]
    which = np.flatnonzero((side != 0) & (surface.share[:, number] > 0.0) & rebounces)
    triangle, corners = surface.triangle[which], np.ascontiguousarray(surface.corners[which].transpose(1, 2, 0))
    centre = (corners[0] + corners[1] + corners[2]) / 3.0
    rays = leg.rays(centre.T)
    direction, field = _columns(rays.direction), _columns(rays.polarization(polarization))
    normal = _columns(planes.normal.take(triangle, axis=0)) * side[which]
    return RayTubes(
        corners, centre, normal, triangle, direction, field, centre, direction, rays.length,
        surface.share[which, number], surface.cell[which], LONGEST * surface.longest[which],
    )  # fmt: skip


def hits(
    tubes: RayTubes, planes: Planes, scene: TriangleScene, bounces: int, smallest: Floats, lit: Flags
) -> Iterator[RayTubes]:
    """The tubes after each reflection at a surface, up to `bounces` surfaces in all, the first one counted.

    smallest: (F,) length of edges below which tubes on each triangle of the mesh are not divided [m]; lit: (F,) whether any leg
    that receives reaches the triangle, without which no tube ends there.
    """
    for bounce in range(2, bounces + 1):
        wanted = lit if bounce == bounces else lit | planes.may_rebounce.any(axis=1)
        tubes = _reflected(tubes, planes, scene, smallest, wanted)
        if not len(tubes):
            return
        yield tubes


def _reflected(tubes: RayTubes, planes: Planes, scene: TriangleScene, smallest: Floats, wanted: Flags) -> RayTubes:
    """The tubes that hit another surface of the body after reflection at this one, divided where parts of one hit different
    planes; wanted: (F,) triangles where they matter."""
    tubes = tubes.chosen(_may_hit_more(tubes, planes))
    direction, field = specular_reflection(tubes.direction.T, tubes.field.T, tubes.normal.T)
    tubes = replace(tubes, direction=np.ascontiguousarray(direction.T), field=np.ascontiguousarray(field.T))
    plane = np.append(np.where(wanted, planes.number, -1), -1)  # the last one for rays that hit nothing
    hit = _hits_of_corners(tubes, scene)
    done = []
    for level in range(MAX_HALVINGS + 1):
        number = plane[hit]
        edges = _squared_edges(tubes.corners)
        longest = edges.max(axis=0, initial=0.0)
        mixed = ((number[1:] != number[0]).any(axis=0) & (longest > smallest[tubes.triangle] ** 2)) | (
            (number[0] >= 0) & (longest > tubes.longest**2)
        )
        if level == MAX_HALVINGS:
            mixed[:] = False
        divided = _largest(np.flatnonzero(mixed), longest)
        ends = number[0] >= 0
        ends[divided] = False
        hitting = np.flatnonzero(ends)
        done.append(replace(tubes.chosen(hitting), triangle=hit[0, hitting]))
        if not len(divided):
            break
        tubes, hit = _divided(tubes.chosen(divided), hit[:, divided], edges[:, divided].argmax(axis=0), scene)
    return _projected(RayTubes.joined(done), planes)


def _largest(which: Indices, size: Floats) -> Indices:
    """Of tubes `which`, as many as may be divided at once, the largest ones by `size`."""
    if 2 * len(which) <= MAX_DIVIDED:
        return which
    return np.sort(which[np.argsort(-size[which], kind="stable")[: MAX_DIVIDED // 2]])


def _hits_of_corners(tubes: RayTubes, scene: TriangleScene) -> Indices:
    """The triangles (4, M) that rays from the centre and from near the corners hit, -1 for none."""
    begin = np.concatenate([tubes.centre[None], tubes.corners + INSET * (tubes.centre - tubes.corners)])
    return _first_hits(begin, tubes, scene)


def _first_hits(begin: Floats, tubes: RayTubes, scene: TriangleScene) -> Indices:
    """The triangles (N, M) that rays from points (N, 3, M) hit, which travel as the tubes (M,) do."""
    count = len(begin)
    lifted = begin + (OFFSET + OFFSET_RELATIVE * scene.radius) * tubes.normal
    direction = np.broadcast_to(tubes.direction.T, (count, len(tubes), 3)).reshape(-1, 3)
    return scene.first_hit(lifted.transpose(0, 2, 1).reshape(-1, 3), direction).reshape(count, -1)


def _squared_edges(corners: Floats) -> Floats:
    """Squared lengths (3, M) of the edges of triangles (3, 3, M), edge i from corner i to i + 1 [m^2]."""
    x, y, z = (corners[[1, 2, 0]] - corners).transpose(1, 0, 2)
    return np.asarray(x * x + y * y + z * z)


def _divided(tubes: RayTubes, hit: Indices, edge: Indices, scene: TriangleScene) -> tuple[RayTubes, Indices]:
    """Both halves (2 M,) of each tube, and what their rays (4, 2 M) hit. Corners that they have from the whole tube are not
    traced again."""
    twice, turn, middle = halved(tubes, edge)
    at_middle = _first_hits((middle + INSET * (tubes.centre - middle))[None], tubes, scene)[0]
    at_centre = _first_hits(twice.centre[None], twice, scene)[0]
    a, b, c = np.take_along_axis(hit[1:], turn, axis=0)
    corners = np.concatenate([np.stack([a, at_middle, c]), np.stack([at_middle, b, c])], axis=1)
    return twice, np.concatenate([at_centre[None], corners])


def halved(tubes: RayTubes, edge: Indices) -> tuple[RayTubes, Indices, Floats]:
    """Both halves (2 M,) of each tube where it is reflected, the order (3, M) of the corners in which they are cut, and where
    (3, M).

    edge: (M,) that is cut in the middle, i from corner i to i + 1.
    """
    turn = (edge + np.arange(3)[:, None]) % 3
    a, b, c = np.take_along_axis(tubes.corners, turn[:, None, :], axis=0)
    middle = (a + b) / 2.0
    corners = np.concatenate([np.stack([a, middle, c]), np.stack([middle, b, c])], axis=2)
    twice = tubes.chosen(np.tile(np.arange(len(tubes)), 2))
    centre = (corners[0] + corners[1] + corners[2]) / 3.0
    offset = centre - twice.centre
    along = dot(offset, twice.direction)
    across = offset - along * twice.direction
    direction = twice.direction + across / twice.length
    direction /= np.sqrt(dot(direction, direction))
    length = twice.length + along + dot(across, across) / (2.0 * twice.length)
    begin = twice.begin + offset
    return replace(twice, corners=corners, centre=centre, direction=direction, begin=begin, length=length), turn, middle


def _may_hit_more(tubes: RayTubes, planes: Planes) -> Indices:
    front = dot(tubes.normal, planes.normal.take(tubes.triangle, axis=0).T) > 0.0
    return np.flatnonzero(planes.may_rebounce[tubes.triangle, np.where(front, 0, 1)])


def _projected(tubes: RayTubes, planes: Planes) -> RayTubes:
    """Tubes projected along their direction onto the plane of `triangle`, without those that graze it or lie behind it."""
    point, normal = (_columns(column.take(tubes.triangle, axis=0)) for column in (planes.point, planes.normal))
    facing = dot(normal, tubes.direction)
    normal = np.where(facing > 0.0, -normal, normal)
    facing = np.maximum(np.abs(facing), 1e-9)
    travel = (dot(tubes.corners.transpose(1, 0, 2), normal[:, None]) - dot(point, normal)) / facing
    corners = tubes.corners + travel[:, None] * tubes.direction
    middle = (travel[0] + travel[1] + travel[2]) / 3.0
    centre = tubes.centre + middle * tubes.direction
    projected = replace(tubes, corners=corners, centre=centre, normal=normal, length=tubes.length + middle)
    return projected.chosen(np.flatnonzero((middle > 0.0) & (facing > GRAZING)))


def dot(a: Floats, b: Floats) -> Floats:
    """Products (..., M) of vectors (3, ..., M)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _columns(vectors: Floats) -> Floats:
    """Vectors (M, 3) by axis (3, M)."""
    return np.ascontiguousarray(vectors.T)
