"""Ray tubes from facet to facet of a body: what they carry, where they start, and their parts.

A tube is a triangle throughout: a flat reflector maps corners to corners along parallel lines, so its footprint on the next
surface is integrated in closed form too. Vectors stand by axis, (3, M): numpy works on such columns several times faster than
on rows of three.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.lit_facets import Planes, Surface

LONGEST = 1.5  # times the longest edge that the phase allows a facet: a tube that hits something is divided above it
EVERY = -(2**31)  # rank below all: of tubes that count wherever they end


class Launch(NamedTuple):
    """Where tubes start (S,).

    direction: (3, S) of travel before, of unit length.
    field: (3, S) that arrives, of unit length.
    leg: (S,) number of the leg.
    share: (S,) of the area that the leg reaches.
    cell: (S,) size of the cell in which fields are summed [m].
    longest: (S,) edge above which a tube is divided where it hits something [m].
    rank: (S,) of the surface.
    least: (S,) rank of the last surface below which tubes do not count.
    """

    direction: Floats
    field: Floats
    leg: Indices
    share: Floats
    cell: Floats
    longest: Floats
    rank: Indices
    least: Indices


@dataclass(frozen=True)
class RayTubes:
    """Ray tubes (M,) where they hit a surface.

    launch: where they start.
    launched: (M,) index of that.
    corners: (3, 3, M) of the footprint, by corner and axis [m].
    centre: (3, M) of the footprint [m].
    normal: (3, M), of unit length, on the lit side.
    triangle: (M,) of the mesh.
    direction: (3, M) of travel, of unit length.
    field: (3, M) that arrives, over that at the first surface.
    length: (M,) of the way from the antenna to here [m].
    begin: (3, M) where the ray through the centre meets the first surface, on its way there or a little beyond [m].
    first_length: (M,) of the way from the antenna to there [m].
    bounces: (M,) surfaces on the way here.
    chain: (S, M) the triangle of each of up to S surfaces on the way, this one too, -1 where there are fewer.
    """

    launch: Launch
    launched: Indices
    corners: Floats
    centre: Floats
    normal: Floats
    triangle: Indices
    direction: Floats
    field: Floats
    length: Floats
    begin: Floats
    first_length: Floats
    bounces: Indices
    chain: Indices

    def __len__(self) -> int:
        return len(self.launched)

    @classmethod
    def joined(cls, parts: "Sequence[RayTubes]") -> "RayTubes":
        """The tubes of several parts that start in the same places."""
        if len(parts) == 1:
            return parts[0]
        columns = (np.concatenate([getattr(part, name) for part in parts], axis=-1) for name in cls._columns())
        return cls(parts[0].launch, *columns)

    def chosen(self, which: Indices) -> "RayTubes":
        """The tubes `which`."""
        return RayTubes(self.launch, *(getattr(self, name).take(which, axis=-1, mode="clip") for name in self._columns()))

    @classmethod
    def _columns(cls) -> list[str]:
        return list(cls.__dataclass_fields__)[1:]


def launched_tubes(
    surface: Surface, legs: Sequence[BodyLeg], polarization: str, planes: Planes, rank: Indices, every: Sequence[bool]
) -> RayTubes:
    """The tubes at the triangles that legs light, where anything of the body is there to be hit next.

    rank: (F,) of the triangles of the mesh; every: of each leg, whether its tubes count whatever the rank of the last surface.
    """
    parts = [_launched(surface, number, leg, polarization, planes) for number, leg in enumerate(legs)]
    which = np.concatenate([part[0] for part in parts])
    leg = np.repeat(np.arange(len(parts)), [len(part[0]) for part in parts])
    corners, centre, normal, direction, field, length = (
        np.concatenate(column, axis=-1) for column in zip(*(part[1:] for part in parts), strict=True)
    )
    triangle = surface.triangle[which]
    least = np.where(np.array(every)[leg], EVERY, rank[triangle])
    longest = LONGEST * surface.longest[which]
    launch = Launch(
        direction, field, leg, surface.share[which, leg], surface.cell[which], longest, rank[triangle], least
    )  # fmt: skip
    count = len(which)
    return RayTubes(
        launch, np.arange(count), corners, centre, normal, triangle, direction, field, length, centre, length,
        np.ones(count, dtype=np.int64), triangle[None],
    )  # fmt: skip


def _launched(surface: Surface, number: int, leg: BodyLeg, polarization: str, planes: Planes) -> tuple[Any, ...]:
    """Of one leg: which triangles; corners, centre and normal of the tubes there, direction, field and length of the leg."""
    side = surface.side[:, number]
    rebounces = planes.may_rebounce[surface.triangle, np.where(side > 0, 0, 1)]
    which = np.flatnonzero((side != 0) & (surface.share[:, number] > 0.0) & rebounces)
    corners = np.ascontiguousarray(surface.corners[which].transpose(1, 2, 0))
    centre = (corners[0] + corners[1] + corners[2]) / 3.0
    normal = by_axis(planes.normal.take(surface.triangle[which], axis=0)) * side[which]
    rays = leg.rays(centre.T)
    return which, corners, centre, normal, by_axis(rays.direction), by_axis(rays.polarization(polarization)), rays.length


def cross(a: Floats, b: Floats) -> Floats:
    """Cross products (3, ..., M) of vectors (3, ..., M)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a: Floats, b: Floats) -> Floats:
    """Products (..., M) of vectors (3, ..., M)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def by_axis(vectors: Floats) -> Floats:
    """Vectors (M, 3) by axis (3, M)."""
    return np.ascontiguousarray(vectors.T)
