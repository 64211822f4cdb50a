"""Methods of the signal chain, from the documented chirp sum to the engine's grid: the same echoes in, profiles out.

Every method is built for a radar and then run on echoes and spokes. Whatever it prepares once for a radar is not timed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.echo.antenna import one_way_gain
from radar_service.echo.echoes import Echoes
from radar_service.echo.sweep import BeamTable
from radar_service.fidelity import PRESETS
from radar_service.frames import wrap_angle
from radar_service.receive.beam import azimuth_kernel, grid_rows, sweep
from radar_service.receive.chirp_sum import (
    chirp,
    chirp_sum,
    compress,
    exact_chirp_sum,
    impulse_sum,
    pulse_times,
    sample_delay,
    window,
)
from radar_service.receive.compression import Compression, compression_for
from radar_service.receive.grid import Kernel, lay, lay_swept
from radar_service.scene.world import Radar

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Profiles = NDArray[np.complex64]
Run = Callable[[Echoes, Indices], Profiles]

TILE = 16  # azimuths at a time, as the engine takes them


@dataclass(frozen=True)
class Method:
    """One method at one setting: what makes profiles (K, N) of echoes for spokes (K,).

    radar: with the sampling rate of this method; first: where sample 0 stands, in steps; reach: how far from boresight
    echoes are taken [rad], each azimuth for itself, or None where the whole turn is worked out at once from all echoes;
    slow: whether it is timed on a thinned list of echoes only.
    """

    family: str
    setting: str
    run: Run
    radar: Radar
    first: float
    reach: float | None
    preset: str | None = None
    slow: bool = False

    @property
    def places(self) -> Floats:
        """Ranges (N,) [m] of the samples."""
        return np.asarray((np.arange(self.radar.bins) + self.first) * self.radar.range_step, dtype=np.float64)


class NearestBin(Kernel):
    """No kernel: an echo goes to the bin it is in."""

    def weights(self, x: Floats) -> tuple[Indices, Floats]:
        """The nearest sample (E,) and weight 1 (E, 1)."""
        return np.rint(x).astype(np.int64), np.ones((len(x), 1))

    def transform(self, frequency: Floats) -> Floats:
        """A single sample's: 1 at all frequencies."""
        return np.ones(np.shape(frequency))


def methods(radar: Radar) -> list[Method]:
    """Every method at every setting for a radar that sends chirps."""
    presets = {p.kernel_width: name for name, p in PRESETS.items() if p.chain == "corrected"}
    plain = partial(Method, radar=radar, first=0.5, reach=None)
    widths = [
        plain("Kaiser-Bessel grid", f"{w} bins", gridded(radar, compression_for(radar, w)), preset=presets.get(w))
        for w in (2, 4, 6, 8)
    ]
    single = compression_for(radar, 6)
    rounded = plain("single-precision range", "float32", in_single(gridded(radar, single), radar.wavelength))
    nearest = plain("nearest bin", "1 bin", gridded(radar, with_kernel(single, NearestBin(1, 1.0))))
    return [*_chirp_sums(radar), nearest, *widths, *_rates(radar), rounded, *_swept(radar)]


def _chirp_sums(radar: Radar) -> list[Method]:
    def one(family: str, extent: float, run: Run, slow: bool) -> Method:
        return Method(family, f"{extent:g} beamwidths", run, radar, 0.0, extent * radar.beamwidth, slow=slow)

    found = []
    for extent in (1.5, 12.0):
        reach = extent * radar.beamwidth
        found.append(one("integer-delay chirps", extent, chirps(radar, reach, chirp_sum), slow=True))
        found.append(one("integer delays, FFT", extent, chirps(radar, reach, impulse_sum), slow=False))
        found.append(one("exact-delay chirps", extent, exact_chirps(radar, reach), slow=True))
    return sorted(found, key=lambda method: method.family)


def _rates(radar: Radar) -> list[Method]:
    found = []
    for factor in (1.0, 1.25, 2.0, 4.0):
        step = radar.range_step * radar.sample_rate / (factor * radar.bandwidth)
        bins = int(np.ceil(radar.bins * radar.range_step / step - 1e-9))
        other = replace(radar, sample_rate=factor * radar.bandwidth, bins=bins)
        run = gridded(other, compression_for(other, 6))
        found.append(Method("sampling rate", f"{factor:g} B", run, other, 0.5, None))
    return found


def _swept(radar: Radar) -> list[Method]:
    """As moving echoes are laid: azimuth by azimuth, the beam cut."""
    extents = (1.5, 3.0, 6.0, 12.0, 24.0)
    compression = compression_for(radar, 6)
    return [
        Method(
            "azimuth by azimuth", f"{e:g} beamwidths", swept(radar, compression, e * radar.beamwidth), radar, 0.5,
            e * radar.beamwidth,
        )
        for e in extents
        if e * radar.beamwidth < np.pi
    ]  # fmt: skip


def with_kernel(compression: Compression, kernel: Kernel) -> Compression:
    """The same compression for echoes laid with another kernel."""
    frequency = scipy.fft.fftfreq(compression.size)
    multiplier = compression.echo_multiplier * (compression.kernel.transform(frequency) / kernel.transform(frequency))
    return replace(compression, kernel=kernel, echo_multiplier=multiplier.astype(np.complex64))


def gridded(radar: Radar, compression: Compression) -> Run:
    """The engine's way for what rests: laid once on azimuth x range, one beam for the whole turn."""
    rows = grid_rows(radar.azimuths, radar.beamwidth)
    kernel = azimuth_kernel(radar.beamwidth, rows, PRESETS["balanced"].beam_kernel_width)

    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        row = echoes.azimuth % (2.0 * np.pi) * (rows / (2.0 * np.pi))
        column = echoes.range / radar.range_step - 0.5
        grid = lay((rows, compression.size), row, column, echoes.amplitude, kernel, compression.kernel)
        turn = sweep(grid, partial(one_way_gain, beamwidth=radar.beamwidth, pattern=radar.pattern), kernel, radar.azimuths)
        tiles = [compression.profiles(turn[spokes[i : i + TILE]]) for i in range(0, len(spokes), TILE)]
        return np.concatenate(tiles)

    return run


def swept(radar: Radar, compression: Compression, extent: float) -> Run:
    """The engine's way for what moves: laid along range alone, for each azimuth the echoes within `extent` [rad]."""
    pattern = partial(one_way_gain, beamwidth=radar.beamwidth, pattern=radar.pattern)
    table = BeamTable(pattern, radar.beamwidth, extent, TILE * radar.azimuth_step)
    tables = compression.kernel.tables()

    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        tiles = []
        for i in range(0, len(spokes), TILE):
            boresight = spokes[i : i + TILE] * radar.azimuth_step
            offset = wrap_angle(boresight - echoes.azimuth[:, None])
            near = np.flatnonzero((np.abs(offset) <= extent).any(axis=1))
            weight = table(offset[near].astype(np.float32))
            amplitude = (weight * echoes.amplitude[near, None]).astype(np.complex64)
            column = echoes.range[near] / radar.range_step - 0.5
            laid = lay_swept(compression.size, column, np.zeros(amplitude.shape, np.float32), amplitude, tables)
            tiles.append(compression.profiles(laid))
        return np.concatenate(tiles)

    return run


def in_single(run: Run, wavelength: float) -> Run:
    """The same with ranges, and so phases, that a float32 holds: what trusting a ray tracer's distance would do."""

    def rounded(echoes: Echoes, spokes: Indices) -> Profiles:
        single = echoes.range.astype(np.float32).astype(np.float64)
        phase = np.exp(-4j * np.pi / wavelength * (single - echoes.range))
        return run(Echoes(single, echoes.azimuth, echoes.amplitude * phase), spokes)

    return rounded


Sum = Callable[[Indices, Floats, Floats, NDArray[np.complex128], int], NDArray[np.complex128]]


def chirps(radar: Radar, extent: float, adding: Sum) -> Run:
    """The documented chain under the corrected beam: delays rounded to samples, chirps added, one matched filter."""
    sent = chirp(pulse_times(radar.pulse, radar.sample_rate), radar.bandwidth, radar.pulse)
    weights = window(radar.window, sent.size)

    def one(distance: Floats, amplitude: NDArray[np.complex128]) -> NDArray[np.complex128]:
        delay = sample_delay(distance, radar.sample_rate)
        received = adding(delay, np.abs(amplitude), np.angle(amplitude), sent, radar.bins)
        return compress(received, sent, weights, radar.bins)

    return _each_azimuth(radar, extent, one)


def exact_chirps(radar: Radar, extent: float) -> Run:
    """The same with the chirp evaluated at every echo's own delay."""
    sent = chirp(pulse_times(radar.pulse, radar.sample_rate), radar.bandwidth, radar.pulse)
    weights = window(radar.window, sent.size)

    def one(distance: Floats, amplitude: NDArray[np.complex128]) -> NDArray[np.complex128]:
        received = exact_chirp_sum(
            distance, np.abs(amplitude), np.angle(amplitude), radar.bandwidth, radar.pulse, radar.sample_rate, radar.bins
        )
        return compress(received, sent, weights, radar.bins)

    return _each_azimuth(radar, extent, one)


def _each_azimuth(
    radar: Radar, extent: float, one: Callable[[Floats, NDArray[np.complex128]], NDArray[np.complex128]]
) -> Run:
    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        profiles = np.empty((len(spokes), radar.bins), dtype=np.complex64)
        for k, spoke in enumerate(spokes):
            offset = wrap_angle(spoke * radar.azimuth_step - echoes.azimuth)
            near = np.flatnonzero(np.abs(offset) <= extent)
            gain = one_way_gain(offset[near], radar.beamwidth, radar.pattern)
            profiles[k] = one(echoes.range[near], gain * echoes.amplitude[near])
        return profiles

    return run
