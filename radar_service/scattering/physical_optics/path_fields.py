"""What facets and ray tubes scatter from one leg into another: amplitudes, whole paths, and where their echoes lie.

With sea reflection a body has two legs, and so four paths: direct both ways, by the sea one way in either order, by the sea both
ways. Facets are integrated once for both orders of a mixed path, as only their currents differ.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Complexes, Floats, Indices
from radar_service.scattering.physical_optics.body_legs import BodyLeg, LegRays
from radar_service.scattering.physical_optics.facet_integral import (
    CURRENT,
    phasors,
)
from radar_service.scattering.physical_optics.lit_facets import LitFacets
from radar_service.scattering.physical_optics.ray_tubes import RayTubes, dot


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
    both_ends: (M,) the weights of a leg at the first and at the last surface, multiplied, where diffraction counts; 1 elsewhere.
    """

    position: Floats
    amplitude: Complexes
    cell: Floats
    both_ends: Complexes | Floats


class LegPhases(NamedTuple):
    """Phases of one leg over facets (M,) with their corners among points (V,).

    corner: (V,) phase at the points [rad].
    at_corner: (V,) exp(j corner).
    bend: (3, M) by how much the phase at the middle of each edge exceeds the mean of its ends, by the opposite corner [rad].
    """

    corner: Floats
    at_corner: Complexes
    bend: Floats


def facet_phases(lit: LitFacets, wave: Wave) -> list[LegPhases]:
    """The phases of each leg over lit facets."""
    result = []
    for rays, lengths in zip(lit.rays, lit.lengths, strict=True):
        phase = -wave.wavenumber * lengths
        result.append(LegPhases(phase, phasors(phase), rays.sags(lit.edges) * (-wave.wavenumber / 4.0)))
    return result


def facet_fields(lit: LitFacets, phases: Sequence[LegPhases], out: int, back: int, wave: Wave) -> Complexes:
    """What facets scatter from leg `out` into leg `back`, and the other way round where they differ, at their points (V,).

    The field of a facet is shared by its corners so that the sum is right for whatever weighs it linearly over the facet. So what
    neighbours give at a common edge cancels, as it should.
    """

    def of_leg(leg: int) -> tuple[Floats | Complexes, ...]:
        rays, phase = lit.rays[leg], phases[leg]
        of_rays = (rays.east, rays.north, rays.rise, rays.flat, rays.length)
        columns = (*of_rays, phase.bend, phase.corner, phase.at_corner, lit.lengths[leg])
        return tuple(map(np.ascontiguousarray, columns))

    shapes = (np.ascontiguousarray(column) for column in (lit.corner, lit.normal, lit.area, lit.side, lit.share))
    total, (count, legs) = np.zeros(len(lit.points), dtype=np.complex128), lit.share.shape
    level = wave.polarization == "h"
    KERNELS.facet_fields(count, legs, out, back, level, *shapes, *of_leg(out), *of_leg(back), total)
    total *= CURRENT / wave.wavelength
    return total


def path_phasor(length: Floats, wave: Wave) -> Complexes:
    """exp(-j k length) (M,) of paths [m]."""
    return phasors(-wave.wavenumber * length)


def tube_fields(tubes: RayTubes, receive: BodyLeg, wave: Wave) -> tuple[Indices, PathFields]:
    """What tubes scatter where they are into a leg: which of them do, and their fields.

    As of facets, only the lit side of a surface scatters.

    A point stands for the whole path. It lies between the path's two ends on the body, and behind them by half of what lies in
    between, at a range of exactly half the path. Then the phase is that of the path, and both change alike as the antenna moves:
    by Fermat's principle a path changes with the rays of its two ends alone, whose mean is the point's.
    """
    back = receive.rays(tubes.centre.T)
    facing = np.flatnonzero(dot(tubes.normal, back.direction.T) + back.tilt * tubes.normal[2] < 0.0)
    seen = facing[receive.reaches(tubes.centre.T.take(facing, axis=0), tubes.triangle[facing])]
    return seen, received_fields(tubes.chosen(seen), back.chosen(seen), receive, wave)


def received_fields(tubes: RayTubes, back: LegRays, receive: BodyLeg, wave: Wave) -> PathFields:
    """What tubes (M,) scatter into a leg, all of which it reaches. back: its rays at their centres."""
    cell = tubes.launch.cell.take(tubes.launched)
    both_ends = 1.0 if receive.sea is None else receive.weight(tubes.begin.T) * receive.weight(tubes.centre.T)
    both_ends = np.broadcast_to(both_ends, len(tubes))
    count, launch = len(tubes), tubes.launch
    columns = [
        tubes.corners, tubes.centre, tubes.direction, tubes.field, tubes.normal, tubes.begin, tubes.length, tubes.first_length,
        tubes.launched, launch.direction, launch.share, back.east, back.north, back.rise, back.flat, back.length, back.curvature,
    ]  # fmt: skip
    position, amplitude, level = np.empty((count, 3)), np.empty(count, dtype=np.complex128), wave.polarization == "h"
    taken = map(np.ascontiguousarray, columns)
    KERNELS.tube_fields(count, len(launch.share), level, wave.wavenumber, *taken, amplitude, position)
    amplitude *= CURRENT / wave.wavelength
    return PathFields(position, amplitude, cell, both_ends)
