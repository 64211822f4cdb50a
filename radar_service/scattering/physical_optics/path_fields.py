"""What facets and ray tubes scatter from one leg into another: amplitudes, whole paths, and where their echoes lie.

With sea reflection a body has two legs, and so four paths: direct both ways, by the sea one way in either order, by the sea both
ways. Facets are integrated once for both orders of a mixed path, as only their currents differ.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import Argument, Kernels, kernels
from radar_service.numerics.types import Complexes, Floats, Indices
from radar_service.scattering.physical_optics.body_legs import BodyLeg, LegRays
from radar_service.scattering.physical_optics.facet_integral import (
    CURRENT,
    bubbles,
    corner_phasors,
    middle_second,
    ordered_means,
    phasors,
    scattering_amplitude,
)
from radar_service.scattering.physical_optics.facets import areas
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
    if compiled := kernels():
        return _compiled_facet_fields(compiled, lit, phases, out, back, wave)
    share = lit.share[:, out] * (lit.share[:, back] if back != out else 1.0)
    both = np.flatnonzero((share > 0.0) & (lit.side[:, out] == lit.side[:, back]))
    current = _current(lit, out, back, wave)
    if back != out:
        current += _current(lit, back, out, wave)
    strength = (current * lit.area * share * lit.side[:, out]).take(both)
    ray_out, ray_back, corner = phases[out], phases[back], lit.corner.take(both, axis=1)
    phase = (ray_out.corner + ray_back.corner).take(corner)
    order = middle_second(phase)
    corner, bend = corner.take(order), (ray_out.bend + ray_back.bend).take(both, axis=1).take(order)
    parts = ordered_means(phase.take(order), (ray_out.at_corner * ray_back.at_corner).take(corner), bubbles(bend))
    parts *= (1.0 - 0.5 * (_spreading(lit, out, both, corner) + _spreading(lit, back, both, corner))) * strength
    index, total = corner.ravel(), np.empty(len(lit.points), dtype=np.complex128)
    total.real = np.bincount(index, parts.real.ravel(), len(total))
    total.imag = np.bincount(index, parts.imag.ravel(), len(total))
    total *= CURRENT / wave.wavelength
    return total


def _compiled_facet_fields(
    compiled: Kernels, lit: LitFacets, phases: Sequence[LegPhases], out: int, back: int, wave: Wave
) -> Complexes:
    """Runs the kernel that does what `facet_fields` does."""

    def of_leg(leg: int) -> tuple[Argument, ...]:
        rays, phase = lit.rays[leg], phases[leg]
        of_rays = (rays.east, rays.north, rays.rise, rays.flat, rays.length)
        columns = (*of_rays, phase.bend, phase.corner, phase.at_corner, lit.lengths[leg])
        return tuple(map(np.ascontiguousarray, columns))

    shapes = (np.ascontiguousarray(column) for column in (lit.corner, lit.normal, lit.area, lit.side, lit.share))
    total, (count, legs) = np.zeros(len(lit.points), dtype=np.complex128), lit.share.shape
    level = wave.polarization == "h"
    compiled.run("facet_fields", count, legs, out, back, level, *shapes, *of_leg(out), *of_leg(back), total)
    total *= CURRENT / wave.wavelength
    return total


def _current(lit: LitFacets, out: int, back: int, wave: Wave) -> Floats:
    """(p . d)(n . E) - (p . E)(n . d) of facets (M,) from a leg into another, as of `scattering_amplitude`."""
    ray_out, ray_back, name = lit.rays[out], lit.rays[back], wave.polarization
    beside = ray_back.north * ray_out.east - ray_back.east * ray_out.north
    alike = ray_out.east * ray_back.east + ray_out.north * ray_back.north
    if name == "h":
        along, same = beside * ray_out.flat, alike
    else:
        along = ray_back.flat * ray_out.rise - ray_back.rise * ray_out.flat * alike
        same = ray_back.rise * ray_out.rise * alike + ray_back.flat * ray_out.flat
    return np.asarray(along * ray_out.along_field(lit.normal, name) - same * ray_out.along(lit.normal))


def _spreading(lit: LitFacets, leg: int, which: Indices, corner: Indices) -> Floats:
    """By how much the spreading of a leg lowers the field at corners (3, N) of facets `which` (N,), a share."""
    return np.asarray(lit.lengths[leg].take(corner) / lit.rays[leg].length.take(which) - 1.0)


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
    if compiled := kernels():
        return PathFields(*_compiled_tube_fields(compiled, tubes, back, wave), cell, both_ends)
    share = tubes.launch.share.take(tubes.launched)
    surface = areas(tubes.corners.transpose(2, 0, 1)) * share * _mean_phasors(tubes, back, wave)
    received = back.polarization(wave.polarization)
    amplitude = scattering_amplitude(tubes.direction.T, tubes.field.T, received, tubes.normal.T, surface, wave.wavelength)
    amplitude *= path_phasor(tubes.length + back.length, wave)
    return PathFields(_behind(tubes, back), amplitude, cell, both_ends)


def _compiled_tube_fields(compiled: Kernels, tubes: RayTubes, back: LegRays, wave: Wave) -> tuple[Floats, Complexes]:
    """Positions (M, 3) [m] and amplitudes (M,) [m] of `received_fields`, by a kernel."""
    count, launch = len(tubes), tubes.launch
    columns = [
        tubes.corners, tubes.centre, tubes.direction, tubes.field, tubes.normal, tubes.begin, tubes.length, tubes.first_length,
        tubes.launched, launch.direction, launch.share, back.east, back.north, back.rise, back.flat, back.length, back.curvature,
    ]  # fmt: skip
    position, amplitude, level = np.empty((count, 3)), np.empty(count, dtype=np.complex128), wave.polarization == "h"
    taken = map(np.ascontiguousarray, columns)
    compiled.run("tube_fields", count, len(launch.share), level, wave.wavenumber, *taken, amplitude, position)
    amplitude *= CURRENT / wave.wavelength
    return position, amplitude


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
    half, launched = (tubes.centre - tubes.begin) / 2.0, tubes.launch.direction.take(tubes.launched, axis=1)
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
