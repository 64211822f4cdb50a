"""Fields of small convex bodies at many instants at once: no part of such a body occludes another, and nothing bounces on it.

A passage of the beam in which shadows of others move over a body needs its fields at nearly every spoke. They are sums on the
nodes of one lattice, fixed in the body's frame, so they are amplitudes of the same scattering centres.
"""

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Complexes, Floats, Indices
from radar_service.scattering.model import BodyEchoes
from radar_service.scattering.physical_optics.body_facets import BodyFacets
from radar_service.scattering.physical_optics.convex_sights import Casters, Sights
from radar_service.scattering.physical_optics.facet_integral import CURRENT
from radar_service.scattering.physical_optics.lit_facets import Planes
from radar_service.scattering.physical_optics.path_fields import Wave
from radar_service.scattering.physical_optics.scattering_centres import DROPPED, UPRIGHT
from radar_service.scattering.physical_optics.sea_field import FLATTEST
from radar_service.scattering.physical_optics.triangle_cuts import AT_LEVEL, above_water

OVERHANG = 1e-6  # of an outward normal: what faces down by more is lit by the sea, past what the body itself hides
PATHS = 3  # direct, by the sea one way, by the sea both ways


class Centres(NamedTuple):
    """Scattering centres (U,) of a body at instants (S,): position (U, 3) [m] in its frame, how many ways go by the sea (U,), and
    amplitude (U, S) [m], 0 where there is none."""

    position: Floats
    path: Indices
    amplitude: Complexes

    @classmethod
    def of(cls, echoes: Sequence[BodyEchoes]) -> Self:
        """The centres of echoes of one body at each instant, whose lattices are the same."""
        rows = [np.column_stack([each.position, each.path]) for each in echoes]
        centre, number = np.unique(np.concatenate(rows), axis=0, return_inverse=True)
        amplitude = np.zeros((len(centre), len(echoes)), dtype=np.complex128)
        instant = np.repeat(np.arange(len(echoes)), [len(each) for each in echoes])
        amplitude[number.reshape(-1), instant] = np.concatenate([each.amplitude for each in echoes])
        return cls(centre[:, :3], centre[:, 3].astype(np.int64), amplitude)

    @classmethod
    def joined(cls, parts: Sequence[Self], instants: Sequence[Indices]) -> Self:
        """The centres of several parts of the instants, each of some (S',)."""
        count = sum(len(which) for which in instants)
        amplitude = np.zeros((sum(len(part.path) for part in parts), count), dtype=np.complex128)
        first = 0
        for part, which in zip(parts, instants, strict=True):
            amplitude[first : first + len(part.path), which] = part.amplitude
            first += len(part.path)
        return cls(
            np.concatenate([part.position for part in parts]), np.concatenate([part.path for part in parts]), amplitude
        )


class ConvexFacets(NamedTuple):
    """The facets of a convex body above the sea, as the kernel takes them.

    corners, triangle, facet: of coarse ones (M,), as of `Surface`.
    point, normal, outside: of triangles (F,) of the mesh, as of `Planes` and `outward_side`; outside is 0 where none is lit.
    fine_corner, fine_points, first_fine: of fine ones, as of `BodyFacets`.
    box: (8, 3) around what is dry [m].
    longest: edge that parts may have [m].
    first, extent: (3,) the first cell of a lattice about all, and how many nodes it has along each axis.
    steps, base: (3,) sizes of its cells and a node [m].
    """

    corners: Floats
    triangle: Indices
    facet: Indices
    point: Floats
    normal: Floats
    outside: NDArray[np.int8]
    fine_corner: Indices
    fine_points: Floats
    first_fine: Indices
    box: Floats
    longest: float
    first: Indices
    extent: Indices
    steps: Floats
    base: Floats

    @classmethod
    def of(
        cls, facets: BodyFacets, vertices: Floats, triangles: Floats, planes: Planes, outside: NDArray[np.int8], water: float,
        legs: int, box: Floats,
    ) -> "ConvexFacets | None":  # fmt: skip
        """Of a body whose mesh has `vertices` (V, 3) and `triangles` (F, 3, 3) [m]; None where it overhangs the sea.

        water: height of the sea in its frame [m]; legs: as of `Sights`.
        """
        down = planes.normal[:, 2] * outside < -OVERHANG
        wet = (triangles[:, :, 2] <= water + AT_LEVEL).all(axis=1)
        if (down & ~wet).any():
            return None
        above, origin = above_water(facets.surface.corners, water)
        uncut = (above == facets.surface.corners[origin]).all((1, 2))
        cell, longest = float(facets.surface.cell[0]), float(facets.surface.longest[0])
        steps = np.array([cell, cell, min(UPRIGHT * cell, FLATTEST if legs > 1 else np.inf)])
        base = np.array([0.0, 0.0, water])
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        low[2] = max(low[2], water)
        first = np.floor((low - base) / steps).astype(np.int64) - 1  # 1: where a shadow's edge is rounded
        extent = np.floor((high - base) / steps).astype(np.int64) + 3 - first
        return cls(
            np.ascontiguousarray(above),
            np.ascontiguousarray(facets.surface.triangle[origin]),
            np.where(uncut, facets.surface.facet[origin], -1),
            np.ascontiguousarray(planes.point),
            np.ascontiguousarray(planes.normal),
            np.where(down, 0, outside).astype(np.int8),
            np.ascontiguousarray(facets.fine),
            np.ascontiguousarray(facets.points),
            np.ascontiguousarray(facets.first),
            np.ascontiguousarray(box),
            longest,
            first,
            extent,
            steps,
            base,
        )

    def centres(self, sights: Sights, casters: Casters, wave: Wave, reflectivity: float, most: int) -> Centres | None:
        """Scattering centres of the body; None where more than `most` triangles cast shadows at any instant."""
        count, paths = len(sights.heading), PATHS if sights.legs > 1 else 1
        amplitude = np.zeros((count, paths, int(np.prod(self.extent))), dtype=np.complex128)
        state = np.zeros(count, dtype=np.int64)
        sizes = (
            len(self.triangle),
            len(self.normal),
            len(self.first_fine) - 1,
            self.fine_corner.shape[1],
            len(self.fine_points),
            len(casters.begin) - 1,
        )
        poses = (sights.position, np.cos(sights.heading), np.sin(sights.heading), sights.antenna)
        KERNELS.convex_fields(
            count, sights.legs, wave.polarization == "h", *sizes, most, True, amplitude.shape[2], wave.wavenumber,
            sights.earth_radius, DROPPED, self.longest, *self[:10], *map(np.ascontiguousarray, (*poses, *casters)),
            self.first, self.extent, self.steps, self.base, amplitude, state,
        )  # fmt: skip
        if state.any():
            return None
        path, node = np.nonzero(amplitude.any(axis=0))
        index = np.stack(np.unravel_index(node, tuple(self.extent)), axis=1) + self.first
        chosen = amplitude[:, path, node].T * (CURRENT / wave.wavelength * reflectivity**0.5)
        return Centres(index * self.steps + self.base, path, np.ascontiguousarray(chosen))
