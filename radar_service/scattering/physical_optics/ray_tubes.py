"""Ray tubes from facet to facet of a body: where each one hits, with which field, and what it scatters from there.

A tube is a triangle throughout: a flat reflector maps corners to corners along parallel lines, so its footprint on the next
surface is integrated in closed form too. Only its middle ray is traced to the next triangle.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.facet_integral import (
    polarization_of,
    scattering_amplitude,
    specular_reflection,
    triangle_phases,
)
from radar_service.scattering.physical_optics.facets import Facets
from radar_service.trace.embree import TriangleScene
from radar_service.types import Complexes, Flags, Floats, Indices

Visible = Callable[[Floats, Indices], Flags]  # which points (M, 3) on triangles (M,) have a line of sight to the antenna

# m; a bounce starts this far off its surface (docs/reference-values.md#embree: 0.1 mm still hits itself in 7 % of cases)
OFFSET = 1e-3
OFFSET_RELATIVE = 1e-6  # of the body's radius: ten times float32 rounding of its coordinates
GRAZING = 0.01  # cosine below which a footprint is over a hundred tubes long, and its middle ray no longer represents it


@dataclass(frozen=True)
class Wave:
    """The wave: wavelength [m] and the radar's polarization, "h" or "v"."""

    wavelength: float
    polarization: str

    @property
    def wavenumber(self) -> float:
        """[rad/m]"""
        return 2.0 * np.pi / self.wavelength


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
    inner: (M,) path from there to here [m].
    """

    corners: Floats
    centre: Floats
    normal: Floats
    triangle: Indices
    direction: Floats
    field: Floats
    begin: Floats
    inner: Floats

    def __len__(self) -> int:
        return len(self.inner)

    def chosen(self, which: Indices) -> "RayTubes":
        """The tubes `which`, rising indices."""
        if len(which) == len(self):
            return self  # all of them
        return RayTubes(*(getattr(self, name).take(which, axis=0) for name in self.__dataclass_fields__))


class Planes(NamedTuple):
    """Of the triangles (F,) of a mesh: a point (F, 3) [m] and the unit normal (F, 3), 0 where there is no area."""

    point: Floats
    normal: Floats


def illuminated_facets(
    facets: Facets, planes: Planes, outside: NDArray[np.int8], antenna: Floats, wave: Wave, visible: Visible
) -> RayTubes:
    """The tubes from the antenna (3,) to all facets visible to it, whichever way these are wound.

    outside: (F,) as from `outward_side`; the inner side of a closed body is never lit.
    """
    above = np.einsum("ij,ij->i", planes.normal, antenna - planes.point)  # all facets of a triangle show the same side
    lit = np.flatnonzero((above * outside + (outside == 0) > 0.0).take(facets.triangle))
    centre, triangle = facets.centre.take(lit, axis=0), facets.triangle.take(lit)
    kept = np.flatnonzero(visible(centre, triangle))
    lit, centre, triangle = lit[kept], centre.take(kept, axis=0), triangle[kept]
    facing = facets.normal.take(lit, axis=0) * np.where(above < 0.0, -1.0, 1.0)[triangle, None]
    toward, _ = _direction_and_distance(antenna, centre)
    field = polarization_of(toward, wave.polarization)
    return RayTubes(facets.corners.take(lit, axis=0), centre, facing, triangle, -toward, field, centre, np.zeros(len(lit)))


def hits(tubes: RayTubes, planes: Planes, scene: TriangleScene, may_rebounce: Flags, bounces: int) -> Iterator[RayTubes]:
    """The tubes at their first surface, and again after each reflection, up to `bounces` surfaces in all.

    may_rebounce: (F, 2) whether there is anything to hit before the front and before the back of each triangle.
    """
    for bounce in range(bounces):
        if not len(tubes):
            return
        yield tubes
        if bounce + 1 < bounces:
            tubes = _reflected(tubes, planes, scene, may_rebounce)


def _reflected(tubes: RayTubes, planes: Planes, scene: TriangleScene, may_rebounce: Flags) -> RayTubes:
    """The tubes that hit another surface of the body after reflection at this one."""
    tubes = tubes.chosen(_may_hit_more(tubes, planes, may_rebounce))
    direction, field = specular_reflection(tubes.direction, tubes.field, tubes.normal)
    offset = OFFSET + OFFSET_RELATIVE * scene.radius
    hit = scene.first_hit(tubes.centre + offset * tubes.normal, direction)
    hitting = np.flatnonzero(hit >= 0)
    tubes = replace(tubes.chosen(hitting), direction=direction[hitting], field=field[hitting], triangle=hit[hitting])
    return _projected(tubes, planes)


def _may_hit_more(tubes: RayTubes, planes: Planes, may_rebounce: Flags) -> Indices:
    front = np.einsum("ij,ij->i", tubes.normal, planes.normal.take(tubes.triangle, axis=0)) > 0.0
    return np.flatnonzero(may_rebounce[tubes.triangle, np.where(front, 0, 1)])


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
    projected = replace(tubes, corners=corners, centre=centre, normal=normal, inner=tubes.inner + middle)
    return projected.chosen(np.flatnonzero(middle > 0.0))


def scattered_field(tubes: RayTubes, launch: Floats, receive: Floats, wave: Wave) -> tuple[Floats, Complexes]:
    """Field that tubes scatter toward `receive` (3,): phase centres (M, 3) and scattering amplitudes (M,) [m].

    A point stands for a path R1 + inner + R2. Where launch and receive coincide, it lies between the path's two ends on the
    body, and behind them by half of what lies in between, at a range of exactly half the path. Then the phase is that of the
    path, and both change alike as the antenna moves: by Fermat's principle a path changes with the lines of sight of its two
    ends alone, whose mean is the point's. Elsewhere the point is the path's last one, and the amplitude holds the rest of the
    phase, so that exp(-jk (|launch - point| + |point - receive|)) completes it.
    """
    end = tubes.centre
    toward, last = _direction_and_distance(receive, end)
    gradient = tubes.direction - toward
    surface = _areas(tubes.corners) * triangle_phases(tubes.corners, end, gradient, wave.wavenumber)
    received = polarization_of(toward, wave.polarization)
    amplitude = scattering_amplitude(tubes.direction, tubes.field, received, tubes.normal, surface, wave.wavelength)
    if not tubes.inner.any():  # they have come straight from the antenna
        return end, amplitude
    _, first = _direction_and_distance(launch, tubes.begin)
    if receive is not launch:
        _, direct = _direction_and_distance(launch, end)
        return end, amplitude * np.exp(-1j * wave.wavenumber * (first + tubes.inner - direct))
    behind, _ = _direction_and_distance(launch, (tubes.begin + end) / 2.0)
    return launch - behind * ((first + tubes.inner + last) / 2.0)[:, None], amplitude


def _direction_and_distance(antenna: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Unit vectors (M, 3) and distances (M,) from points to the antenna (3,)."""
    offset = antenna - points
    distance = np.sqrt(np.einsum("ij,ij->i", offset, offset))  # a third of the time of linalg.norm
    return offset / np.maximum(distance, 1e-9)[:, None], distance


def _areas(corners: Floats) -> Floats:
    (ux, uy, uz), (vx, vy, vz) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return np.asarray(np.sqrt(x * x + y * y + z * z) / 2.0)
