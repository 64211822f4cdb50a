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
from radar_service.scattering.physical_optics.ray_tubes import RayTubes
from radar_service.types import Complexes, Floats


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


def tube_fields(tubes: RayTubes, launch: BodyLeg, receive: BodyLeg, wave: Wave) -> PathFields:
    """What tubes scatter where they are into a leg.

    As of facets, only the lit side of a surface scatters.

    A point stands for the whole path. It lies between the path's two ends on the body, and behind them by half of what lies in
    between, at a range of exactly half the path. Then the phase is that of the path, and both change alike as the antenna moves:
    by Fermat's principle a path changes with the rays of its two ends alone, whose mean is the point's.
    """
    back = receive.rays(tubes.centre)
    lit = np.flatnonzero(np.einsum("ij,ij->i", tubes.normal, back.direction) + back.tilt * tubes.normal[:, 2] < 0.0)
    seen = lit[receive.visible(tubes.centre.take(lit, axis=0), tubes.triangle[lit])]
    tubes, back = tubes.chosen(seen), back.chosen(seen)
    offset = tubes.corners.transpose(1, 0, 2) - tubes.centre
    edges = np.roll(tubes.corners, -1, axis=1).transpose(1, 0, 2) - np.roll(tubes.corners, -2, axis=1).transpose(1, 0, 2)
    ahead, bent = _spherical(offset, tubes), -_across2(edges, tubes) / (8.0 * tubes.length)
    phases = -wave.wavenumber * (ahead + back.detours(offset))
    bends = -wave.wavenumber * (bent + back.sags(edges) / 4.0)
    surface = areas(tubes.corners) * tubes.share * corner_phasors(phases, bends).sum(axis=0)
    received = back.polarization(wave.polarization)
    amplitude = scattering_amplitude(tubes.direction, tubes.field, received, tubes.normal, surface, wave.wavelength)
    length = tubes.length + back.length
    return PathFields(_behind(tubes, back, length, launch, receive), amplitude * path_phasor(length, wave), tubes.cell)


def _spherical(offset: Floats, tubes: RayTubes) -> Floats:
    """How much longer the way of a tube's wave is to points around its centre (N, M) [m]; offset: (N, M, 3)."""
    along = np.einsum("nmi,mi->nm", offset, tubes.direction)
    return np.asarray(along + _across2(offset, tubes) / (2.0 * tubes.length))


def _across2(vectors: Floats, tubes: RayTubes) -> Floats:
    """Squared lengths (N, M) of vectors (N, M, 3) across tubes [m^2]."""
    along = np.einsum("nmi,mi->nm", vectors, tubes.direction)
    return np.asarray(np.einsum("nmi,nmi->nm", vectors, vectors) - along * along)


def _behind(tubes: RayTubes, back: LegRays, length: Floats, launch: BodyLeg, receive: BodyLeg) -> Floats:
    middle = (tubes.begin + tubes.centre) / 2.0
    gradient = (tubes.launched + back.direction) / 2.0
    missing = (length - launch.length(middle) - receive.length(middle)) / 2.0
    steep = np.maximum(np.einsum("ij,ij->i", gradient, gradient), 1e-3)
    return np.asarray(middle + gradient * (missing / steep)[:, None])
