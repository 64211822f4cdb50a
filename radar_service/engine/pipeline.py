"""The engine, stage by stage: scatterers, line of sight, range histories, grid, beam, compression, noise and effects.

`prepare` does all that a scene needs once. `profiles` computes a few azimuths of any scan from it. What rests relative to the
antenna is kept as finished profiles. What moves, fluctuates, or is shadowed by what moves is computed azimuth by azimuth
(docs/engine.md).

Arithmetic runs in tiles that are the same however spokes are grouped afterwards, so bytes do not depend on the grouping.
"""

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.fft

from radar_service.echo import AzimuthTimes, BeamWeightedEchoes, ObservedEchoes, OccludedEchoes, concatenated, fold_ranges
from radar_service.engine.preparation import Prepared, beam_pattern, column
from radar_service.numerics import (
    BLAS_LIMIT,
    NOISE,
    Complexes,
    Flags,
    Floats,
    Indices,
    Profiles,
    Singles,
    generator,
    wrap_angle,
)
from radar_service.propagation import local_attenuation, two_way_phase
from radar_service.receive import integrate, receiver_noise_power
from radar_service.records import square_law
from radar_service.stages.stage import Added, Tile
from radar_service.world import SightLines

LOSS_STEP = 16  # bins from one to the next at which local attenuation is computed; in dB it is linear between


@dataclass
class Contributions:
    """What each stage added to a tile of azimuths (K,), apart from echoes at rest and noise.

    transmitting: (K,) which azimuths are not blind.
    echoes: of the blocks of the tile: first azimuth, end, and the echoes that are not those of bodies at rest.
    rows: all these echoes spread on grid rows (K, size), where there are any; 0 where blind.
    added: by stages.
    """

    transmitting: Flags = dataclasses.field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    echoes: list[tuple[int, int, BeamWeightedEchoes]] = dataclasses.field(default_factory=list)
    rows: Profiles | None = None
    added: Added = dataclasses.field(default_factory=Added)


@BLAS_LIMIT.held()
def profiles(prepared: Prepared, azimuths: AzimuthTimes, record: Contributions | None = None) -> Profiles:
    """Compressed range profiles (K, bins) [sqrt(W)] of the azimuths (K,) of one tile.

    record: empty; it is filled with what the stages add.
    """
    blind = prepared.scene.blind(azimuths.time, azimuths.boresight)
    if record is not None:
        record.transmitting = ~blind
    rows = moving_rows(prepared, azimuths, record)
    land = land_spectra(prepared, azimuths, rows)
    field = receive(prepared, azimuths, rows if land is None else None, blind, land)
    if record is not None:
        record.rows = with_silence(rows if record.rows is None else record.rows, blind)
    add_resting(prepared, field, azimuths, blind)
    add_stages(prepared, Tile(azimuths, ~blind, field, None if record is None else record.added))
    _integrate(prepared, azimuths, field)
    return field


@BLAS_LIMIT.held()
def contributions(prepared: Prepared, azimuths: AzimuthTimes) -> Contributions:
    """What each stage adds to the azimuths (K,) of one tile; noise is not drawn, and nothing is compressed."""
    blind = prepared.scene.blind(azimuths.time, azimuths.boresight)
    record = Contributions(~blind)
    record.rows = with_silence(echo_rows(prepared, azimuths, record), blind)
    unused = np.zeros((len(blind), prepared.compression.bins), dtype=np.complex64)
    add_stages(prepared, Tile(azimuths, ~blind, unused, record.added))
    return record


def moving_rows(prepared: Prepared, azimuths: AzimuthTimes, record: Contributions | None = None) -> Profiles | None:
    """Moving echoes on grid rows (K, size) before compression, None without any; without land and by R - S for `land_spectra`.

    record: gets what the stages add. Land there has a row for each echo, from which sources are told apart.
    """
    if not land_holds(prepared, azimuths):
        return echo_rows(prepared, azimuths, record)
    assert prepared.land is not None
    if record is not None:
        record.rows = echo_rows(prepared, azimuths, record)
    return echo_rows(prepared, azimuths, None, prepared.land.near(azimuths), prepared.land.shift(azimuths))


def land_spectra(prepared: Prepared, azimuths: AzimuthTimes, moving: Profiles | None) -> Profiles | None:
    """Spectra (K, size) of grid rows of land under way and `moving_rows`, before compression; None where land has range
    histories, or is none."""
    if not land_holds(prepared, azimuths):
        return None
    assert prepared.land is not None
    return prepared.land.spectrum(azimuths, moving)


def land_holds(prepared: Prepared, azimuths: AzimuthTimes) -> bool:
    """Whether land under way is taken from its grid at these azimuths."""
    return prepared.land is not None and prepared.land.holds(azimuths)


def echo_rows(
    prepared: Prepared,
    azimuths: AzimuthTimes,
    record: Contributions | None = None,
    near_land: ObservedEchoes | None = None,
    shift: Floats | None = None,
) -> Profiles | None:
    """Moving echoes, each with its range history, spread on grid rows (K, size); None where there are none.

    near_land: the only echoes of land that count; None: all of them. shift: (K,) that ranges, and their phases, are less [m].
    """
    rows: Profiles | None = None
    alone = prepared.land is None and not any(stage.has_echoes for stage in prepared.stages.values())
    if alone and not len(prepared.moving) and not prepared.shadows.possible:
        return rows
    compression = prepared.compression
    for first, stop in blocks(prepared, azimuths, near_land):
        echoes = moving_echoes(prepared, azimuths.part(first, stop), near_land)
        if not len(echoes.range):
            continue
        if record is not None:
            record.echoes.append((first, stop, echoes))
        if rows is None:
            rows = np.zeros((len(azimuths.time), compression.size), dtype=np.complex64)
        step, distance, migration, amplitude = prepared.scene.radar.range_step, *echoes[:3]
        if shift is not None:
            less = shift[first:stop]
            distance, migration = distance - less[0], migration - (less - less[0]).astype(np.float32)
            amplitude = amplitude * two_way_phase(-less, prepared.scene.radar.wavelength).astype(np.complex64)
        compression.spread(rows[first:stop], column(distance, step), migration * np.float32(1.0 / step), amplitude)
    return rows


def with_silence(rows: Profiles | None, blind: Flags) -> Profiles | None:
    """Grid rows (K, size), or their spectra, of which the blind ones (K,) are 0, in place."""
    if rows is not None and blind.any():
        rows[blind] = 0.0
    return rows


def visibility_steps(prepared: Prepared, azimuths: AzimuthTimes) -> Indices:
    """The number (K,) of the visibility step of each azimuth."""
    return np.asarray(azimuths.time // prepared.moving.visibility.interval, dtype=np.int64)


def blocks(prepared: Prepared, azimuths: AzimuthTimes, near_land: ObservedEchoes | None = None) -> Iterator[tuple[int, int]]:
    """First and end of the blocks of a tile, each within one visibility step, so that no azimuth has the shadows of another.

    Neither does a body come or go within a block. near_land: as of `echo_rows`.
    """
    steps, usual = visibility_steps(prepared, azimuths), prepared.fidelity.azimuths_per_block
    edges = {0, len(steps)}
    if steps[0] != steps[-1]:
        edges.update((np.flatnonzero(np.diff(steps)) + 1).tolist())
    edges.update(first for first, _ in prepared.line_of_sight.presences.spans(azimuths.time))
    for start, end in pairwise(sorted(edges)):
        few = prepared.land is None or (near_land is not None and not len(near_land.echoes))
        size = prepared.moving.block_size(azimuths.part(start, end), usual) if few else usual
        for first in range(start, end, size):
            yield first, min(first + size, end)


def moving_echoes(prepared: Prepared, azimuths: AzimuthTimes, near_land: ObservedEchoes | None = None) -> BeamWeightedEchoes:
    """All moving echoes, and the resting ones that they shadow, with range, phase and beam weight at each azimuth.

    near_land: the only echoes of land that count; None: all of them.
    """
    parts: list[BeamWeightedEchoes] = []
    if prepared.land is not None:
        land = prepared.land.echoes
        parts.append(land.echoes(azimuths) if near_land is None else land.of_resting(azimuths, near_land))
    if len(prepared.moving):
        parts += fold_ranges(prepared.moving.echoes, azimuths, prepared.scene.radar)
    for stage in prepared.stages.values():
        parts += fold_ranges(stage.echoes, azimuths, prepared.scene.radar) if stage.has_echoes else []
    if prepared.shadows.possible:
        if len(prepared.shadowed):
            parts += fold_ranges(prepared.shadowed.echoes, azimuths, prepared.scene.radar)
        shadows = prepared.shadows.at(int(azimuths.middle // prepared.moving.visibility.interval), azimuths.middle)
        if len(shadows.range):
            parts.append(_beam_weighted(shadows, azimuths, prepared))
    return concatenated(parts, len(azimuths.time))


def receive(
    prepared: Prepared, azimuths: AzimuthTimes, rows: Profiles | None, blind: Flags, land: Profiles | None = None
) -> Profiles:
    """Compresses grid rows (K, size) and adds receiver noise: profiles (K, bins) [sqrt(W)]. Nothing is received where blind.

    land: spectra (K, size) of other rows, which are used up.
    """
    compression = prepared.compression
    spectrum = compression.joined_spectrum(with_silence(rows, blind), with_silence(land, blind))
    if prepared.scene.environment.noise:
        rng = _noise_generator(prepared, int(azimuths.number[0]))
        if spectrum is None:
            spectrum = compression.noise.draw(len(azimuths.time), rng)
        else:
            compression.noise.add(spectrum, rng)
    if spectrum is None:
        return np.zeros((len(azimuths.time), compression.bins), dtype=np.complex64)
    return compression.from_spectrum(spectrum)


def _noise_generator(prepared: Prepared, number: int, *purpose: int) -> np.random.Generator:
    """Random numbers of the receiver noise of the tile that begins with a spoke of this number."""
    scan, index = divmod(number, prepared.scene.radar.azimuths)
    return generator(prepared.seed, NOISE, *prepared.scene.random_key, scan, index // prepared.tile, *purpose)


def _integrate(prepared: Prepared, azimuths: AzimuthTimes, field: Profiles) -> None:
    """Integrates the pulses of the spokes of a tile; nothing where these have one, or no noise."""
    radar = prepared.scene.radar
    if radar.pulses_integrated > 1 and prepared.scene.environment.noise:
        noise = receiver_noise_power(radar)
        rng = _noise_generator(prepared, int(azimuths.number[0]), radar.pulses_integrated)
        integrate(field, radar.pulses_integrated, noise, rng)


def noise_amplitude(prepared: Prepared, number: int) -> float:
    """The greatest amplitude [sqrt(W)] of the noise of the tile that begins with a spoke of this number, beyond the last bin
    too."""
    rows = min(prepared.tile, prepared.scene.radar.azimuths - number % prepared.scene.radar.azimuths)
    noise = prepared.compression.noise.draw(rows, _noise_generator(prepared, number))
    return float(np.abs(scipy.fft.ifft(noise, axis=1, overwrite_x=True)).max())


def add_resting(prepared: Prepared, field: Profiles, azimuths: AzimuthTimes, blind: Flags) -> None:
    """Adds the finished profiles of all that rests."""
    if prepared.resting_profiles is not None:
        start = int(azimuths.number[0]) % prepared.scene.radar.azimuths
        resting = prepared.resting_profiles[start : start + len(field)]
        loss = resting_loss(prepared, azimuths)
        resting = resting if loss is None else resting * loss
        field += np.where(~blind[:, None], resting, 0) if blind.any() else resting


def resting_loss(prepared: Prepared, azimuths: AzimuthTimes) -> Singles | None:
    """Amplitude factor (K, bins) on what rests, of what attenuates by place and time on boresight; None without any."""
    if not prepared.scene.environment.attenuators or prepared.resting_profiles is None:
        return None
    bins = prepared.scene.radar.bins
    node: Floats = np.arange(0.0, bins + LOSS_STEP, LOSS_STEP)
    level = np.log(_loss_on_boresight(prepared, azimuths, (node + 0.5) * prepared.scene.radar.range_step))
    if not level.any():
        return None
    part = np.arange(LOSS_STEP) / LOSS_STEP
    between = level[:, :-1, None] + np.diff(level, axis=1)[..., None] * part
    return np.exp(between.reshape(len(level), -1)[:, :bins].astype(np.float32))


def _loss_on_boresight(prepared: Prepared, azimuths: AzimuthTimes, distance: Floats) -> Floats:
    """Two-way amplitude factor (K, N) of what attenuates by place and time, at slant ranges (N,) [m] on boresight."""
    count = len(distance)
    antenna = prepared.scene.antenna(azimuths.time).repeat(count, axis=0)
    time, boresight = azimuths.time.repeat(count), azimuths.boresight.repeat(count)
    lines = SightLines(antenna, time, boresight, np.tile(distance, len(azimuths.time)))
    return local_attenuation(prepared.scene.radar, prepared.scene.environment, lines).reshape(-1, count)


def add_stages(prepared: Prepared, tile: Tile, after: Callable[[str], None] = lambda name: None) -> None:
    """Lets each stage add to a tile. after: called after each, with the name of its effect."""
    for name, stage in prepared.stages.items():
        stage.add(tile)
        after(name)


def tile_azimuths(prepared: Prepared, scan: int, start: int) -> AzimuthTimes:
    """The azimuths of the tile of a scan that begins at azimuth `start`, a multiple of `Prepared.tile`."""
    radar = prepared.scene.radar
    number = scan * radar.azimuths + np.arange(start, min(start + prepared.tile, radar.azimuths))
    return AzimuthTimes(number, *radar.schedule(number))


class Engine:
    """Computes scans of a prepared scene tile by tile."""

    def __init__(self, prepared: Prepared) -> None:
        self.prepared = prepared
        radar = prepared.scene.radar
        self.range: Floats = (np.arange(radar.bins, dtype=np.float64) + 0.5) * radar.range_step

    def tiles(self, scan: int, requested: Flags | None = None) -> Iterator[tuple[int, Profiles, Singles]]:
        """One scan: index of each tile's first azimuth, field (K, bins) [sqrt(W)] and power (K, bins) [W]; only tiles that
        hold any of the requested azimuths, where there are flags (A,) of these."""
        for start in self.starts(requested):
            field = profiles(self.prepared, tile_azimuths(self.prepared, scan, start))
            yield start, field, square_law(field)

    def starts(self, requested: Flags | None = None) -> list[int]:
        """The first azimuths of a scan's tiles; only of those that hold any of the requested azimuths (A,)."""
        azimuths, tile = self.prepared.scene.radar.azimuths, self.prepared.tile
        return [n for n in range(0, azimuths, tile) if requested is None or requested[n : n + tile].any()]


def _beam_weighted(echoes: OccludedEchoes, azimuths: AzimuthTimes, prepared: Prepared) -> BeamWeightedEchoes:
    """Resting echoes (E,) at single azimuths (K,)."""
    radar, offset = prepared.scene.radar, wrap_angle(azimuths.boresight - echoes.azimuth[:, None])
    weight: Floats | Complexes = radar.azimuth_gain(offset)
    pattern = beam_pattern(radar, prepared.fidelity)
    if pattern is not None:
        from_bow = echoes.azimuth[:, None] - prepared.scene.platform.heading(azimuths.time)
        weight = weight + pattern.two_way_change(from_bow, -offset)
    if prepared.scene.environment.attenuators:
        weight = weight * _loss_on_boresight(prepared, azimuths, echoes.range).T
    amplitude = (weight * echoes.amplitude[:, None]).astype(np.complex64)
    return BeamWeightedEchoes(echoes.range, np.zeros(amplitude.shape, dtype=np.float32), amplitude, echoes.body)
