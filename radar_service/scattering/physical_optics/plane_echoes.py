"""The echoes of one aspect of planar pieces, exact but for what is too faint to count.

An eye is a point: the antenna, its image in the sea, and images of these in pieces. What it lights is cut out of the pieces by
the planes through the eye and the edges of what lies before them. Of a bounce the eye is mirrored in the first piece, and lights
the second one through it as through a window. The kernel says how fields are sums over the edges of what is lit.
"""

import math
import warnings
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Complexes, Floats, Indices
from radar_service.radar import Radar
from radar_service.scattering.model import NEAREST
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces
from radar_service.scattering.physical_optics.plating import PlatedWalls
from radar_service.world import MAP_POSE, Mesh

# Of the field of the ship's usual largest cell: surfaces and bounces that have less at most are left out
FAINT, FAINT_BOUNCE = 1e-3, 3e-3
MANY = 1000  # pieces; of more, those that add up are the smaller the more there are, so less is left out
# Cuts and pairs of pieces of an aspect, some 2 s, and those of each piece: the shipped tanker has 0.4 million. A mesh whose
# surfaces cross each other everywhere has no end of them.
MOST_WORK, MOST_OF_PIECE = 20_000_000, 100
WORK_OF_LEVEL = 2_000_000  # of an aspect at which a usual cell is looked for: of what takes more some is left out
TOO_MUCH = (
    "metal of {} pieces: an aspect takes over {} cuts, and what is left is missing; surfaces should not cross each other"
)
ASPECTS, FAR = 5, 2000.0  # azimuths and distance [m] at which a usual cell is looked for, from ELEVATION [rad]
ELEVATION, ASKEW = 0.01, 0.38  # no azimuth is ahead or abeam, where walls of ships face
ROOM = 40  # echoes expected of a piece; of more the aspect is evaluated once more
MAX_BEND = 0.3  # rad, two-way, over half an edge (docs/engine.md#errors)
# Of the beam's width and of the range cell that an edge and a cell may take: what weighs them is linear in between
BEAM_SHARE, RANGE_SHARE = 1.0 / 6.0, 1.0 / 4.0
EXTENT_SHARE = 1.0 / 9.0  # of the body, likewise: its sidelobes are what is left of many cells
EDGE_SHARE = 3.0 / 5.0  # of the range cell, of an edge: few lie along the line of sight


@dataclass(frozen=True)
class Wave:
    """The wave: wavelength [m] and the radar's polarization, "h" or "v"."""

    wavelength: float
    polarization: str

    @property
    def wavenumber(self) -> float:
        """[rad/m]"""
        return 2.0 * np.pi / self.wavelength

    def phasor(self, length: Floats) -> Complexes:
        """exp(-j k length) (M,) of paths [m]."""
        result = np.empty(len(length), dtype=np.complex128)
        KERNELS.phasors(len(length), np.ascontiguousarray(-self.wavenumber * length), result)
        return result


class Longest(NamedTuple):
    """The longest edge over which a field may be taken as linear: at most so long [m], so many times the distance, and so many
    times its root [root of m]."""

    edge: float
    wide: float = np.inf
    bend: float = np.inf


class PlaneEchoes(NamedTuple):
    """Fields (N,) that pieces return: place (N, 3) in the body's frame [m], heights of the first and the last surface (N, 2) [m],
    amplitude (N,) with the phase of the whole path [m], how many of its two ways go by the sea (N,), and surfaces in a row (N,).
    Of mixed paths both orders are in it."""

    place: Floats
    ends: Floats
    amplitude: Complexes
    ways: Indices
    surfaces: Indices


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
            cells = [optics.largest_cell((n + ASKEW) / ASPECTS * 2.0 * np.pi, range_cell) for n in range(ASPECTS)]
            level = float(np.median(cells))
        return cls(pieces, wave, bounces, level, walls)

    def largest_cell(self, azimuth: float, range_cell: float) -> float:
        """The field of the largest range cell as seen from far away [m]."""
        toward = np.array([np.sin(azimuth), np.cos(azimuth), 0.0]) * np.cos(ELEVATION) + [0.0, 0.0, np.sin(ELEVATION)]
        leg = BodyLeg(False, MAP_POSE, FAR * toward, np.inf)
        seen, _ = self._within((leg,), -np.inf, Longest(range_cell), WORK_OF_LEVEL)
        if not len(seen.ways):
            return 0.0
        cell = np.floor((seen.place @ toward) / range_cell).astype(np.int64)
        cell -= cell.min()
        sums = np.bincount(cell, seen.amplitude.real) + 1j * np.bincount(cell, seen.amplitude.imag)
        return float(np.abs(sums).max())

    def rotated(self, rotation: Floats) -> "PlaneOptics":
        """The same rotated about the origin by a matrix (3, 3)."""
        return replace(self, pieces=self.pieces.rotated(rotation), rotation=rotation @ self.rotation)

    def echoes(self, legs: tuple[BodyLeg, ...], water: float, longest: Longest) -> PlaneEchoes:
        """What returns by one leg, or by two: the direct one and the one by the sea.

        water: height of the sea in the body's frame [m], -inf: there is none. longest: edge over which a field may be taken as
        linear. Raises MemoryError. Warns where something is left out, as it takes too much.
        """
        most = max(MOST_WORK, MOST_OF_PIECE * len(self.pieces))
        echoes, work = self._within(legs, water, longest, most)
        if work > most:
            warnings.warn(TOO_MUCH.format(len(self.pieces), most), RuntimeWarning, stacklevel=2)
        return echoes

    def _within(self, legs: tuple[BodyLeg, ...], water: float, longest: Longest, most: int) -> tuple[PlaneEchoes, int]:
        """What `echoes` returns, as far as it takes at most so many cuts and pairs of pieces, and how many it took."""
        pieces, pose, room = self.pieces, legs[0].pose, 1000 + ROOM * len(self.pieces)
        faint = self.level * min(1.0, MANY / max(len(pieces), 1))
        middle = _middle(pieces.corner, water)
        eyes = np.array([leg.eye(middle) for leg in legs])
        screens = [leg.screens(middle, eye) for leg, eye in zip(legs, eyes, strict=True)]
        screen_first = np.cumsum([0, *map(len, screens)])
        by_sea, work = np.array([leg.by_sea for leg in legs], dtype=np.int64), np.zeros(1, dtype=np.int64)
        numbers = len(pieces), len(legs), self.bounces, self.wave.polarization == "h", most
        limits = water, self.wave.wavelength, *longest, FAINT * faint, FAINT_BOUNCE * faint
        shapes = pieces.first, pieces.corner, pieces.normal, pieces.patch
        parts = (*shapes, eyes, by_sea, screen_first, np.concatenate(screens), pose.position, legs[0].antenna)
        taken = [np.ascontiguousarray(part) for part in parts]
        turn = float(np.cos(pose.heading)), float(np.sin(pose.heading)), float(legs[0].earth_radius)
        dents = *_dents(self.walls, len(pieces)), np.ascontiguousarray(self.rotation)
        while True:
            place, ends, amplitude = np.empty((room, 3)), np.empty((room, 2)), np.empty(room, dtype=np.complex128)
            ways, surfaces = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
            result = place, ends, amplitude, ways, surfaces
            count = KERNELS.plane_echoes(*numbers, room, *limits, *taken, *turn, *dents, *result, work)
            if count <= room:
                kept = PlaneEchoes(place[:count], ends[:count], amplitude[:count], ways[:count], surfaces[:count])
                return kept, int(work[0])
            room = count


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


class EdgeLimits(NamedTuple):
    """What bounds edges and the cells in which they are summed: range resolution [m], beamwidth [rad], wavelength [m], and the
    extent of the body [m]."""

    range_cell: float
    beamwidth: float
    wavelength: float
    extent: float

    @classmethod
    def of(cls, radar: Radar, mesh: Mesh) -> "EdgeLimits":
        """Of a mesh for this radar."""
        extent = float(np.ptp(mesh.used_vertices, axis=0).max(initial=0.0))
        return cls(radar.range_resolution, radar.beamwidth, radar.wavelength, extent)

    def cell(self, distance: Floats) -> Floats:
        """Sizes [m] of the cells at distances (M,) [m], the same throughout half an octave."""
        if distance.size > 2:
            ends = self.cell(np.array([distance.min(), distance.max()]))
            if ends[0] == ends[1]:
                return np.broadcast_to(ends[:1], distance.shape)
        half_octave = 2.0 ** (np.floor(2.0 * np.log2(np.maximum(distance, NEAREST))) / 2.0)
        widest = min(RANGE_SHARE * self.range_cell, EXTENT_SHARE * self.extent)
        return np.minimum(widest, BEAM_SHARE * self.beamwidth * half_octave)

    @property
    def longest(self) -> Longest:
        """The longest edges: their phase bends by MAX_BEND over half of one, by k (e/2)^2 / R."""
        bend = float(np.sqrt(2.0 * MAX_BEND * self.wavelength / np.pi))
        return Longest(min(EDGE_SHARE * self.range_cell, EXTENT_SHARE * self.extent), BEAM_SHARE * self.beamwidth, bend)

    def coherence(self, nearest: float, upright: float = 1.0, flattest: float = np.inf) -> float:
        """The longer of edge and cell [m] of a body whose nearest part is so far away [m].

        upright: height over length of the cell, which then counts; flattest: what it is at most [m].
        """
        nearest = max(nearest, NEAREST)
        edge, wide, bend = self.longest
        cell = min(upright * float(self.cell(np.array(nearest))), flattest)
        return max(cell, min(edge, wide * nearest, bend * math.sqrt(nearest)))
