"""The echoes of one aspect of planar pieces, exact but for what is too faint to count.

An eye is a point: the antenna, its image in the sea, and images of these in pieces. What it lights is cut out of the pieces by
the planes through the eye and the edges of what lies before them. Of a bounce the eye is mirrored in the first piece, and the
second one is lit by it through the first as through a window; of two bounces likewise again. Fields are sums over the edges of
what is lit, away from specular directions, and closed forms near them (the kernel says how).

The engine does not call this yet: other bodies before a ship, and diffraction at bounces are missing.
"""

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Complexes, Flags, Floats, Indices
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.facets import EdgeLimits
from radar_service.scattering.physical_optics.path_centres import PATHS, PathCentres, flattest, over_nodes
from radar_service.scattering.physical_optics.path_fields import Wave, path_phasor
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces
from radar_service.scattering.physical_optics.plating import PlatedWalls
from radar_service.scattering.physical_optics.scattering_centres import Lattice, strongest
from radar_service.world.poses import MAP_POSE

# Of the field of the ship's usual largest cell: surfaces and bounces that have less at most are left out
FAINT, FAINT_BOUNCE = 1e-3, 3e-3
MANY = 1000  # pieces; of more, those that add up are the smaller the more there are, so less is left out
# Cuts and pairs of pieces of an aspect, some 2 s, and those of each piece: the shipped tanker has 0.4 million. A mesh whose
# surfaces cross each other everywhere has no end of them.
MOST_WORK, MOST_OF_PIECE = 20_000_000, 100
ASPECTS, FAR = 12, 2000.0  # azimuths and distance [m] at which a usual cell is looked for, from ELEVATION [rad]
ELEVATION, ASKEW = 0.01, 0.38  # no azimuth is ahead or abeam, where walls of ships face
ROOM = 40  # echoes expected of a piece; of more the aspect is evaluated once more


class PlaneEchoes(NamedTuple):
    """Fields (N,) that pieces return: place (N, 3) in the body's frame [m], amplitude (N,) with the phase of the whole path [m],
    how many of its two ways go by the sea (N,), and surfaces in a row (N,). Of mixed paths both orders are in it. work: cuts and
    pairs of pieces; above MOST_WORK something is missing."""

    place: Floats
    amplitude: Complexes
    ways: Indices
    surfaces: Indices
    work: int


@dataclass(frozen=True)
class PlaneOptics:
    """Pieces prepared for their echoes.

    wave: wavelength and polarization. bounces: surfaces in a row, 1 to 3. level: field of the usual largest cell [m].
    walls: pieces that are dented between frames; None: there are none. rotation: (3, 3) of the frame from the body's own.
    """

    pieces: PlanarPieces
    wave: Wave
    bounces: int
    level: float
    walls: PlatedWalls | None = None
    rotation: Floats = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of(cls, pieces: PlanarPieces, wave: Wave, bounces: int, range_cell: float, walls: PlatedWalls | None = None) -> Self:
        """Pieces with the field of a usual range cell: the median over azimuths of the largest, by two surfaces in a row and
        without the sea. range_cell: its length [m]."""
        level = 0.0
        for few in range(1, min(bounces, 2) + 1):
            optics = cls(pieces, wave, few, level, walls)
            level = float(
                np.median([optics.largest_cell((n + ASKEW) / ASPECTS * 2.0 * np.pi, range_cell) for n in range(ASPECTS)])
            )
        return cls(pieces, wave, bounces, level, walls)

    def largest_cell(self, azimuth: float, range_cell: float) -> float:
        """The field of the largest range cell as seen from far away [m]."""
        toward = np.array([np.sin(azimuth), np.cos(azimuth), 0.0]) * np.cos(ELEVATION) + [0.0, 0.0, np.sin(ELEVATION)]
        leg = BodyLeg(False, MAP_POSE, FAR * toward, np.inf, _all_visible)
        seen = self.echoes((leg,), -np.inf, range_cell)
        if not len(seen.ways):
            return 0.0
        cell = np.floor((seen.place @ toward) / range_cell).astype(np.int64)
        cell -= cell.min()
        sums = np.bincount(cell, seen.amplitude.real) + 1j * np.bincount(cell, seen.amplitude.imag)
        return float(np.abs(sums).max())

    def rotated(self, rotation: Floats) -> "PlaneOptics":
        """The same rotated about the origin by a matrix (3, 3)."""
        return replace(self, pieces=self.pieces.rotated(rotation), rotation=rotation @ self.rotation)

    def echoes(self, legs: tuple[BodyLeg, ...], water: float, longest: float) -> PlaneEchoes:
        """What returns by one leg, or by two: the direct one and the one by the sea. Nothing else lies before the body.

        water: height of the sea in the body's frame [m], -inf: there is none. longest: edge over which a field may be taken as
        linear [m]. Raises MemoryError.
        """
        pieces, pose, room = self.pieces, legs[0].pose, 1000 + ROOM * len(self.pieces)
        faint = self.level * min(1.0, MANY / max(len(pieces), 1))
        middle = _middle(pieces.corner, water)
        eyes = np.array([_eye(leg, middle) for leg in legs])
        by_sea, work = np.array([leg.by_sea for leg in legs], dtype=np.int64), np.zeros(1, dtype=np.int64)
        most = max(MOST_WORK, MOST_OF_PIECE * len(pieces))
        numbers = len(pieces), len(legs), self.bounces, self.wave.polarization == "h", most
        limits = water, self.wave.wavelength, longest, FAINT * faint, FAINT_BOUNCE * faint
        parts = (pieces.first, pieces.corner, pieces.normal, pieces.patch, eyes, by_sea, pose.position, legs[0].antenna)
        taken = [np.ascontiguousarray(part) for part in parts]
        turn = float(np.cos(pose.heading)), float(np.sin(pose.heading)), float(legs[0].earth_radius)
        dents = *_dents(self.walls, len(pieces)), np.ascontiguousarray(self.rotation)
        while True:
            place, amplitude = np.empty((room, 3)), np.empty(room, dtype=np.complex128)
            ways, surfaces = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
            result = place, amplitude, ways, surfaces, work
            count = KERNELS.plane_echoes(*numbers, room, *limits, *taken, *turn, *dents, *result)
            if count <= room:
                return PlaneEchoes(place[:count], amplitude[:count], ways[:count], surfaces[:count], int(work[0]))
            room = count


@dataclass(frozen=True)
class PlanarBody:
    """A body of planar pieces that nothing shades but itself, with the interface of `OpticalBody`.

    optics: in the frame of the upright body. limits: what bounds edges and cells. reflectivity: power ratio at each surface.
    """

    optics: PlaneOptics
    limits: EdgeLimits
    reflectivity: float

    def leaning(self, lean: Floats) -> "PlanarBody":
        """The same body rotated by a matrix (3, 3), so that the sea is level in its frame."""
        return replace(self, optics=self.optics.rotated(lean))

    def echoes(self, legs: tuple[BodyLeg, ...], water: float = -np.inf) -> list[PathCentres]:
        """The centres of each path of one leg, or of two: the direct one and the one by the sea.

        water: height of the sea in the body's frame [m]; nothing below it scatters.
        """
        corner, sea, wave = self.optics.pieces.corner, legs[0].sea, self.optics.wave
        antenna = legs[0].pose.frame_from_map(legs[0].antenna, np.inf)
        nearest = float(np.linalg.norm(corner - antenna, axis=1).min(initial=np.inf))
        cell, longest = self.limits.at(nearest)
        echoes = self.optics.echoes(legs, water, longest if sea is None else min(longest, sea.longest))
        lattice = Lattice.over(echoes.place, np.full(len(echoes.ways), cell), flattest(legs), water)
        weights, received = over_nodes(legs, lattice, echoes.place, []), legs[0].weight(lattice.nodes) ** 2
        lengths = [leg.length(lattice.nodes) for leg in legs]
        amplitude, result = echoes.amplitude * self.reflectivity ** (echoes.surfaces / 2.0), []
        for out, back in PATHS if len(legs) > 1 else PATHS[:1]:
            part = np.where(echoes.ways == out + back, amplitude, 0.0) * weights[out + back][0]
            sums = lattice.sums(slice(len(part)), part) * path_phasor(-lengths[out] - lengths[back], wave)
            kept = strongest(np.abs(sums * received))
            result.append(PathCentres(out + back, lattice.nodes[kept], sums[kept]))
        return result


def _dents(walls: PlatedWalls | None, pieces: int) -> tuple[Any, ...]:
    """What the kernel takes of plated walls."""
    if walls is None:
        numbers = 1, 2, 2, 1.0, 1.0, 1.0, 0.0
        none = np.zeros(pieces, dtype=np.int64)
        return (*numbers, none - 1, none, np.zeros(2, dtype=np.int64), np.zeros((4, 1, 2)), np.ones(2))
    plating, kept = walls.plating, walls.kept_by_facing
    numbers = *walls.drawn.shape[1:], len(kept), plating.frame, plating.tier, *walls.zone
    return (*numbers, walls.axis, walls.wall, np.array(walls.first), walls.drawn, kept)


def _middle(corner: Floats, water: float) -> Floats:
    """The middle (3,) of the box about what rises above the water."""
    low, high = corner.min(axis=0, initial=np.inf), corner.max(axis=0, initial=-np.inf)
    low[2] = max(low[2], min(water, high[2]))
    return np.asarray((low + high) / 2.0) if len(corner) else np.zeros(3)


def _eye(leg: BodyLeg, middle: Floats) -> Floats:
    """The point (3,) in the body's frame from which straight lines run as a leg does about the middle of the body."""
    rays = leg.rays(middle[None])
    return np.asarray(middle - rays.length[0] * rays.direction[0] / np.linalg.norm(rays.direction[0]))


def _all_visible(points: Floats, triangle: Indices) -> Flags:
    """Pieces say what they hide by themselves."""
    return np.ones(len(points), dtype=np.bool_)
