"""What facets and ray tubes scatter from one leg into another: amplitudes, whole paths, and where their echoes lie.

With sea reflection a body has two legs, and so four paths: direct both ways, by the sea one way in either order, by the sea both
ways. Facets are integrated once for both orders of a mixed path, as only their currents differ.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.scattering.physical_optics.body_legs import BodyLeg, LegRays
from radar_service.scattering.physical_optics.facet_integral import (
    corner_phasors,
    phasors,
    scattering_amplitude,
    shared_means,
)
from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.lit_facets import LitFacets
from radar_service.scattering.physical_optics.ray_tubes import RayTubes, dot
from radar_service.types import Complexes, Flags, Floats, Indices


@dataclass(frozen=True)
class Wave:
    """The wave: wavelength [m] and the radar's polarization, "h" or "v"."""

    wavelength: float
    polarization: str

    @property
    def wavenumber(self) -> float:
        """[rad/m]"""
        return 2.0 * np.pi / self.wavelength


class PathFields(NamedTuple):
    """Fields (M,) by one path.

    position: (M, 3) in the body's frame [m].
    amplitude: (M,) scattering amplitude with the phase of the whole path, out and back [m].
    cell: (M,) size of the cells in which the field is summed [m].
    """

    position: Floats
    amplitude: Complexes
    cell: Floats


class LegPhases(NamedTuple):
    """Phases of one leg over facets (M,) with their corners among points (V,).

    corner: (V,) phase at the points [rad].
    at_corner: (V,) exp(j corner).
    at_edge: (3, M) exp(j x), x by how much the phase at the middle of each edge exceeds the mean of its ends, by the opposite
        corner.
    spreading: (3, M) by how much the spreading lowers the field at the corners, a share.
    """

    corner: Floats
    at_corner: Complexes
    at_edge: Complexes
    spreading: Floats


def facet_phases(lit: LitFacets, wave: Wave) -> list[LegPhases]:
    """The phases of each leg over lit facets."""
    by_corner = np.ascontiguousarray(lit.corners.transpose(1, 0, 2))
    edges = by_corner[[1, 2, 0]] - by_corner[[2, 0, 1]]
    result = []
    for rays, lengths in zip(lit.rays, lit.lengths, strict=True):
        phase, bend = -wave.wavenumber * lengths, rays.sags(edges) * (-wave.wavenumber / 4.0)
        result.append(LegPhases(phase, phasors(phase), phasors(bend), lengths[lit.corner] / rays.length - 1.0))
    return result


def facet_fields(lit: LitFacets, phases: Sequence[LegPhases], one: int, other: int, wave: Wave) -> Complexes:
    """What facets scatter from leg `one` into leg `other`, and the other way round where they differ, at their points (V,).

    The field of a facet is shared by its corners so that the sum is right for whatever weighs it linearly over the facet. So what
    neighbours give at a common edge cancels, as it should.
    """
    share = lit.share[:, one] * (lit.share[:, other] if other != one else 1.0)
    both = np.flatnonzero((share > 0.0) & (lit.side[:, one] == lit.side[:, other]))
    first, second, out, back = lit.rays[one].chosen(both), lit.rays[other].chosen(both), phases[one], phases[other]
    normal = lit.normal.take(both, axis=0) * lit.side[both, one, None]
    surface = areas(lit.corners.take(both, axis=0)) * share[both]
    amplitude = _amplitude(first, second, normal, surface, wave)
    if other != one:
        amplitude += _amplitude(second, first, normal, surface, wave)
    corner = lit.corner.take(both, axis=1)
    at_corner, at_edge = out.at_corner * back.at_corner, (out.at_edge * back.at_edge).take(both, axis=1)
    parts = shared_means((out.corner + back.corner)[corner], at_corner[corner], 4.0 * (at_edge - 1.0))
    parts *= (1.0 - 0.5 * (out.spreading + back.spreading).take(both, axis=1)) * amplitude
    index, total = corner.ravel(), np.empty(len(lit.points), dtype=np.complex128)
    total.real = np.bincount(index, parts.real.ravel(), len(total))
    total.imag = np.bincount(index, parts.imag.ravel(), len(total))
    return total


def path_phasor(length: Floats, wave: Wave) -> Complexes:
    """exp(-j k length) (M,) of paths [m]."""
    return phasors(-wave.wavenumber * length)


def _amplitude(launch: LegRays, receive: LegRays, normal: Floats, surface: Floats, wave: Wave) -> Complexes:
    field, received = launch.polarization(wave.polarization), receive.polarization(wave.polarization)
    return scattering_amplitude(launch.direction, field, received, normal, surface, wave.wavelength)


def tube_fields(tubes: RayTubes, receive: BodyLeg, wave: Wave, whole: Flags) -> tuple[Indices, PathFields]:
    """What tubes scatter where they are into a leg: which of them do, and their fields.

    As of facets, only the lit side of a surface scatters. whole: (F,) triangles of the mesh that the leg reaches as a whole.

    A point stands for the whole path. It lies between the path's two ends on the body, and behind them by half of what lies in
    between, at a range of exactly half the path. Then the phase is that of the path, and both change alike as the antenna moves:
    by Fermat's principle a path changes with the rays of its two ends alone, whose mean is the point's.
    """
    back = receive.rays(tubes.centre.T)
    facing = np.flatnonzero(dot(tubes.normal, back.direction.T) + back.tilt * tubes.normal[2] < 0.0)
    free = whole[tubes.triangle[facing]]
    partly = facing[~free]
    free[~free] = receive.visible(tubes.centre.T.take(partly, axis=0), tubes.triangle[partly])
    seen = facing[free]
    tubes, back = tubes.chosen(seen), back.chosen(seen)
    share, cell = (column.take(tubes.source) for column in (tubes.launch.share, tubes.launch.cell))
    surface = areas(tubes.corners.transpose(2, 0, 1)) * share * _mean_phasors(tubes, back, wave)
    received = back.polarization(wave.polarization)
    amplitude = scattering_amplitude(tubes.direction.T, tubes.field.T, received, tubes.normal.T, surface, wave.wavelength)
    amplitude *= path_phasor(tubes.length + back.length, wave)
    return seen, PathFields(_behind(tubes, back), amplitude, cell)


def _mean_phasors(tubes: RayTubes, back: LegRays, wave: Wave) -> Complexes:
    """Means (M,) of the phasors of tubes and of their rays back over the footprints, 1 at their centres."""
    axes = [np.ascontiguousarray(axis.T) for axis in (back.direction, back.level, back.upright)]
    offset = (tubes.corners - tubes.centre).transpose(1, 0, 2)
    edges = offset[:, [1, 2, 0]] - offset[:, [2, 0, 1]]
    vectors = np.concatenate([offset, edges], axis=1)
    along, back_along, level, upright = (dot(vectors, axis[:, None]) for axis in (tubes.direction, *axes))
    across = dot(vectors, vectors) - along * along
    bent = across / tubes.length + level * level / back.length + upright * upright * back.curvature
    phases = -wave.wavenumber * (along[:3] + back_along[:3] + bent[:3] / 2.0)
    return np.asarray(corner_phasors(phases, wave.wavenumber / 8.0 * bent[3:]).sum(axis=0))


def _behind(tubes: RayTubes, back: LegRays) -> Floats:
    """The points (M, 3) that stand for paths; wavefronts about their ends are spheres, which errs by centimetres."""
    half, launched = (tubes.centre - tubes.begin) / 2.0, tubes.launch.direction.take(tubes.source, axis=1)
    there = _spherical(half, launched, tubes.first_length)
    back_there = _spherical(-half, back.direction.T, back.length)
    missing = (tubes.length - tubes.first_length - there - back_there) / 2.0
    gradient = (launched + back.direction.T) / 2.0
    steep = np.maximum(dot(gradient, gradient), 1e-3)
    return np.asarray((tubes.begin + half + gradient * (missing / steep)).T)


def _spherical(offset: Floats, direction: Floats, length: Floats) -> Floats:
    """How much longer a way (M,) is to points at offsets (3, M) [m]."""
    along = dot(offset, direction)
    return np.asarray(along + (dot(offset, offset) - along * along) / (2.0 * length))
