"""Land under way on grid rows: spread once a passage on a polar grid that follows own ship, and taken from there by the beam.

The grid has one row an azimuth or several, or fewer where the band of beam and speed asks for no more, and columns (R - S) / step
(`echo.land`). The row of an azimuth is a product of the rows around it with the beam's gain and what is left of the phase, both
of points on boresight of these rows, corrected for the kernel along azimuth, by rings even in 1 / R.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy.fft

from radar_service.echo import (
    GROUND,
    NEAREST_BORDER,
    PIECE,
    AzimuthTimes,
    BoresightTrack,
    LandPassages,
    MovingEchoes,
    ObservedEchoes,
    joined,
    slant_range,
)
from radar_service.numerics import Floats, Indices, Profiles, ResultCache, wrap_angle
from radar_service.propagation import turned_back, two_way_phase
from radar_service.radar import Radar
from radar_service.receive import Compression, Kernel, KernelTable, PulseKernel, range_kernel, spread
from radar_service.records import Fidelity
from radar_service.scattering import scattering_model
from radar_service.stages.registry import changed_pattern
from radar_service.world import Body, Motion, Platform, Scene

RINGS = 8  # bearings of points in a ring differ by less than 1/16 of what they change 150 m off
BEAM_BAND, OVERSAMPLING = 0.8859, 2.9  # as of `antenna.grid_rows`
ENOUGH = 4.4  # of oversampling: more rows err as much; of wide beams 2.9 leaves up to 0.8 % of cells off by 1 dB
WIDTHS = 2.0  # beamwidths off boresight up to which the phase that is left counts: beyond, sidelobes are below -26 dB
EDGE = 8  # rows beyond the beam, into which the correction for the kernel reaches
SPARE = 4  # pieces kept beyond those of a tile: threads may be so many apart before one is computed again
KEPT = 2**15  # rows in the beam of all weights kept: at 32 azimuths and 3 rings 25 MB
VISIBLE = 0.35  # of all points of a low coast, or of buildings (tests/measurements)
# Measured there: CPU time of an echo at an azimuth, of a point once a passage, but for its line of sight, which range histories
# need as often, and of a row of the grid, twice as long to be sure
PAIR_SECONDS, PASSAGE_SECONDS, ROW_SECONDS = 48e-9, 0.5e-6, 0.5e-3
# m/s of heave, and of the antenna by roll and pitch, that the grid follows to -38 dB. Measured: -38 dB at 0.8 m/s of heave and
# -33 dB at 2.1; -50 dB at 6.9 m/s of the antenna, and at 12.6 every 60th cell is off by 1 dB
MAX_HEAVE, MAX_SWING = 0.8, 7.0
MAX_BEAM = 1.8 * np.pi  # rad that the beam, and pieces at its ends, may cover: no point is in it twice


class GridPiece(NamedTuple):
    """A piece of land on the grid: rows (R, columns), the first column, the echoes that are near, which points these are, and
    how many all echoes are."""

    rows: Profiles
    first_column: int
    near: ObservedEchoes
    near_points: Indices
    echoes: int


class LandRows:
    """Grid rows of land at any azimuths. Safe to call from several threads.

    echoes: the same land with a range history for each echo: where pieces do not hold, and for sources one by one.
    """

    def __init__(
        self,
        scene: Scene,
        passages: LandPassages,
        echoes: MovingEchoes,
        fidelity: Fidelity,
        compression: Compression,
    ) -> None:
        radar = scene.radar
        self.passages, self.echoes = passages, echoes
        self._scene, self._compression = scene, compression
        band = BEAM_BAND / radar.pattern.aperture_beamwidth(radar.beamwidth)  # cycles per radian, either way
        band += 2.0 / radar.wavelength * passages.top_way * WIDTHS * radar.beamwidth  # of the phase that is left beside S
        least = 4.0 * np.pi * band / radar.azimuths  # rows an azimuth without oversampling
        by_azimuth = PIECE * int(np.ceil(OVERSAMPLING * least))
        enough = int(np.ceil(ENOUGH * least * PIECE))
        self._rows_per_piece = min(by_azimuth, enough)  # a piece begins on a row
        self._rows_per_azimuth = self._rows_per_piece / PIECE
        self._kernel = Kernel(fidelity.beam_kernel_width, self._rows_per_azimuth / least)
        self._table = KernelTable(self._kernel.tables()[0])
        self._extent = fidelity.beam_extent * radar.beamwidth
        ring = np.arange(RINGS)
        self._ring_begin = np.append(0.0, NEAREST_BORDER * RINGS / (RINGS - ring[1:]))
        self._ring_middle = np.asarray(NEAREST_BORDER * RINGS / (RINGS - ring - 0.5), dtype=np.float64)
        covered = 2.0 * (self._extent / radar.azimuth_step * self._rows_per_azimuth + EDGE + self._kernel.width)
        pieces = 2 + int(covered) // self._rows_per_piece + SPARE
        self._pieces: ResultCache[int, GridPiece] = ResultCache(pieces, scene.revision)
        self._kept: ResultCache[tuple[int | bytes, ...], Profiles] = ResultCache(1 + KEPT // int(covered))

    def holds(self, azimuths: AzimuthTimes) -> bool:
        """Whether the land at these azimuths is taken from the grid: where own ship meets no corner."""
        pieces = self._pieces_of(azimuths)
        return self.passages.track.is_smooth(pieces[0] * PIECE, (pieces[-1] + 1) * PIECE)

    def near(self, azimuths: AzimuthTimes) -> ObservedEchoes:
        """The echoes of land that keep a range history each, and that the beam may meet at these azimuths."""
        pieces = [self._piece(number) for number in self._pieces_of(azimuths)]
        return joined([piece.near for piece in pieces], [piece.near_points for piece in pieces])

    def echoes_about(self, azimuths: AzimuthTimes) -> int:
        """How many echoes the pieces have that the beam may meet at these azimuths."""
        return sum(self._piece(number).echoes for number in self._pieces_of(azimuths))

    def spectrum(self, azimuths: AzimuthTimes, moving: Profiles | None = None) -> Profiles:
        """Spectra (K, size) of the grid rows of all other land, before compression; and of rows `moving` (K, size) by R - S."""
        total = self._rows(azimuths)
        if moving is not None:
            total += moving
        shift = self.shift(azimuths)
        spectrum: Profiles = scipy.fft.fft(total, axis=1, overwrite_x=True)
        columns = 2.0 * np.pi * scipy.fft.fftfreq(self._compression.size) / self._scene.radar.range_step
        phase = shift.astype(np.float32)[:, None] * columns.astype(np.float32)
        phase += (4.0 * np.pi / self._scene.radar.wavelength * shift % (2.0 * np.pi)).astype(np.float32)[:, None]
        spectrum *= turned_back(phase)
        return spectrum

    def shift(self, azimuths: AzimuthTimes) -> Floats:
        """S (K,) at these azimuths [m]."""
        return self.passages.track.shift(azimuths.number.astype(np.float64))

    def _rows(self, azimuths: AzimuthTimes) -> Profiles:
        """Rows (K, size) of these azimuths, with columns (R - S) / step."""
        rows = self._band(azimuths)
        pieces = {number: self._piece(number) for number in self._pieces_of(azimuths)}
        begins = np.rint(self._ring_begin / self._scene.radar.range_step).astype(np.int64)
        edges = [*begins.tolist(), self._compression.size]
        total = np.zeros((len(azimuths.number), self._compression.size), dtype=np.complex64)
        first = min((piece.first_column for piece in pieces.values()), default=0)
        last = max((piece.first_column + piece.rows.shape[1] for piece in pieces.values()), default=0)
        filled = [ring for ring in range(RINGS) if max(edges[ring], first) < min(edges[ring + 1], last)]
        for ring, weights in zip(filled, self._weights(azimuths, rows, filled), strict=True):
            for number, piece in pieces.items():
                begin = max(edges[ring], piece.first_column)
                end = min(edges[ring + 1], piece.first_column + piece.rows.shape[1])
                if begin < end:
                    self._add(total[:, begin:end], weights, int(rows[0]), number, piece, begin)
        return total

    def _add(self, total: Profiles, weights: Profiles, first_row: int, number: int, piece: GridPiece, begin: int) -> None:
        """Adds to columns (K, C), from column `begin` on, those of a piece, by weights (K, R) of rows from `first_row` on."""
        start = number * self._rows_per_piece - (self._kernel.width // 2 - 1)
        low, high = max(start, first_row), min(start + len(piece.rows), first_row + weights.shape[1])
        columns = slice(begin - piece.first_column, begin - piece.first_column + total.shape[1])
        if low < high:
            total += weights[:, low - first_row : high - first_row] @ piece.rows[low - start : high - start, columns]

    def _band(self, azimuths: AzimuthTimes) -> Indices:
        """The grid rows (R,) that the beam covers at any of these azimuths, numbered on from azimuth number 0."""
        first, last = self._rows_per_azimuth * azimuths.number[[0, -1]]
        each_side = self._extent / self._scene.radar.azimuth_step * self._rows_per_azimuth + EDGE
        return np.arange(math.floor(first - each_side), math.ceil(last + each_side) + 1)

    def _pieces_of(self, azimuths: AzimuthTimes) -> range:
        """The numbers of the pieces whose rows, with their kernels, the beam covers at these azimuths."""
        (first, last), width = self._band(azimuths)[[0, -1]].tolist(), self._kernel.width
        return range((first - width) // self._rows_per_piece, (last + width) // self._rows_per_piece + 1)

    def _piece(self, number: int) -> GridPiece:
        return self._pieces.get(number, lambda: self._computed(number))

    def _computed(self, number: int) -> GridPiece:
        piece, margin = self.passages.piece(number), self._kernel.width // 2 - 1
        column = piece.distance / self._scene.radar.range_step - 0.5
        first = int(column.min(initial=self._compression.size)) - self._compression.kernel.width
        columns = max(0, int(column.max(initial=0.0)) + self._compression.kernel.width - first)
        shape = self._rows_per_piece + self._kernel.width, columns
        row = piece.row * self._rows_per_azimuth + margin
        rows = spread(shape, row, column - first, piece.amplitude, self._table, KernelTable(self._compression.tables[0]))
        return GridPiece(rows, first, piece.near, piece.near_points, len(piece.row) + len(piece.near.echoes))

    def _weights(self, azimuths: AzimuthTimes, rows: Indices, rings: list[int]) -> Profiles:
        """The weights (D, K, R) of rows at each azimuth in rings (D,), kept from scan to scan while own ship goes straight."""
        radar, number, motion = self._scene.radar, azimuths.number, self._scene.own_ship
        before = int(number[0]) // radar.azimuths * radar.azimuths
        rows_before, distance = before * self._rows_per_piece // PIECE, self._ring_middle[rings]
        turns = motion.sway is not None or rows[0] < 0
        velocity = np.zeros((1, 3)) if turns else motion.pose(radar.time_of_spokes(rows / self._rows_per_azimuth)).velocity
        if turns or (velocity != velocity[0]).any() or rows_before * PIECE != before * self._rows_per_piece:
            return self._on_boresight(self.passages.track, number, rows, distance)

        def computed() -> Profiles:
            steady = Motion(np.array([-radar.rotation_period]), np.zeros((1, 3)), np.zeros(1), velocity[0])
            track = BoresightTrack(replace(self._scene, platform=Platform(steady)))
            return self._on_boresight(track, number - before, rows - rows_before, distance)

        return self._kept.get((int(number[0]) - before, len(number), *rings, velocity[0].tobytes()), computed)

    def _on_boresight(self, track: BoresightTrack, numbers: Indices, rows: Indices, distance: Floats) -> Profiles:
        """The field (D, K, R) at azimuth numbers (K,) of what boresight points at on each row, `distance` (D,) [m] away, over
        that there and without the change of S; corrected for the kernel along azimuth."""
        radar = self._scene.radar
        at, number = rows / self._rows_per_azimuth, numbers.astype(np.float64)
        point = track.points_on_boresight(at, distance, GROUND)
        offset = point[:, :, None] - track.antenna(number)
        passed, now = (slant_range(each, track.earth_radius) for each in (point - track.antenna(at), offset))
        off = wrap_angle(track.bearing(number) - np.arctan2(*track.apparent(offset, track.level(number))))
        left = (now - track.shift(number)) - (passed - track.shift(at))[..., None]
        gain = radar.azimuth_gain(off) * (passed[..., None] / now) ** 2
        gain[np.abs(off) > self._extent] = 0.0
        field = gain * two_way_phase(left, radar.wavelength)
        size = int(scipy.fft.next_fast_len(len(rows)))
        spectrum = scipy.fft.fft(field.swapaxes(1, 2), size, axis=2) / self._kernel.transform(scipy.fft.fftfreq(size))
        corrected = scipy.fft.ifft(spectrum, axis=2)[:, :, : len(rows)]
        return np.ascontiguousarray(corrected, dtype=np.complex64)


def follows_own_ship(scene: Scene, fidelity: Fidelity) -> bool:
    """Whether land may be spread on a grid that follows own ship: each azimuth is not computed by itself, as in `reference`, the
    beam covers no point twice, nothing changes it, its pulse has the first echoes alone, and is not its own kernel, and own
    ship sways gently."""
    radar, beam = scene.radar, 2.0 * fidelity.beam_extent * scene.radar.beamwidth
    rows = 2.0 * OVERSAMPLING * BEAM_BAND / radar.pattern.aperture_beamwidth(radar.beamwidth)  # per radian, or more
    edges = 2.0 * (EDGE + fidelity.beam_kernel_width) / rows
    narrow = beam + edges + 4 * PIECE * radar.azimuth_step < MAX_BEAM
    pulse = radar.second_time_around or isinstance(range_kernel(radar, fidelity.kernel_width), PulseKernel)
    if scene.own_ship.at_rest or changed_pattern(radar) is not None or fidelity.azimuths_per_block <= 1:
        return False
    return narrow and not pulse and _sways_gently(scene)


def _sways_gently(scene: Scene) -> bool:
    """Whether own ship heaves and its mast swings no faster than the grid follows."""
    sway = scene.own_ship.sway
    if sway is None:
        return True
    roll, pitch, _, heave = sway.likely_rates
    return bool(heave <= MAX_HEAVE and scene.radar.height * (roll + pitch) <= MAX_SWING)


def saves_time(points: int, radar: Radar, fidelity: Fidelity) -> bool:
    """Whether so many points of land take less time on the grid than with a range history each."""
    each = 2.0 * fidelity.beam_extent * radar.beamwidth / radar.azimuth_step + 2.0 * fidelity.azimuths_per_block
    return points * VISIBLE * (each * PAIR_SECONDS - PASSAGE_SECONDS) > ROW_SECONDS * radar.azimuths


def is_diffuse_land(body: Body, fidelity: Fidelity) -> bool:
    """Whether a body is a diffuse surface that rests on the map; such surfaces do not fluctuate."""
    return body.at_rest and scattering_model(body, fidelity.sampler).has_resting_points
