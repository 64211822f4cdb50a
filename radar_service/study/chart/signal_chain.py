"""Methods of the signal chain, from the documented chirp sum to the engine's grid. Each makes profiles of echoes.

A method is built for a radar and then run on echoes and spokes. Its preparation for the radar is not timed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.fft

from radar_service.echo import BeamTable, Echoes
from radar_service.numerics import Complexes, Floats, Indices, Profiles, wrap_angle
from radar_service.radar import Radar, grid_rows, printed_two_way
from radar_service.receive import (
    Compression,
    Kernel,
    PulseKernel,
    azimuth_kernel,
    beam_filter,
    chirp,
    chirp_sum,
    compress,
    compression_for,
    exact_chirp_sum,
    impulse_sum,
    pulse_times,
    sample_delay,
    spread,
    waveform_spectra,
    window,
)
from radar_service.records import PRESETS, Fidelity
from radar_service.trace import BOX_BEAMWIDTHS

Run = Callable[[Echoes, Indices], Profiles]
BLOCK = 16  # azimuths computed together, as in the engine
BALANCED = PRESETS["balanced"]
CORRECTED = {name: preset for name, preset in PRESETS.items() if preset.engine == "corrected"}
WIDTHS = (2, 4, 6, 8)  # range bins of the kernel
RATES = (1.0, 1.25, 2.0, 4.0)  # sampling rate over bandwidth
EXTENTS = (1.5, 6.0, 24.0)  # beamwidths each side of boresight, beside those of the presets
Sum = Callable[[Indices, Floats, Floats, Complexes, int], Complexes]  # as chirp_sum
Beam = Callable[[Floats], Floats]  # offset from boresight [rad] to the weight of an amplitude
INTEGER_DELAY = "integer-delay chirps"


@dataclass(frozen=True)
class Method:
    """One method at one setting.

    run: makes profiles (K, N) of echoes for spokes (K,). radar: with the sampling rate of this method. first: range of sample 0
    [range steps]. reach: largest offset of an echo from boresight [rad]; None where the whole scan is computed at once. preset:
    the one that uses this setting, if any. slow: whether it is timed on a subset of the echoes."""

    family: str
    setting: str
    run: Run
    radar: Radar
    first: float
    reach: float | None
    preset: str | None = None
    slow: bool = False

    @property
    def sample_range(self) -> Floats:
        """Ranges (N,) [m] of the samples."""
        return np.asarray((np.arange(self.radar.bins) + self.first) * self.radar.range_step, dtype=np.float64)


class NearestBin(Kernel):
    """Adds each echo to the nearest range bin only."""

    def weights(self, x: Floats) -> tuple[Indices, Floats]:
        """Returns the nearest sample (E,) and the weight 1 (E, 1)."""
        return np.rint(x).astype(np.int64), np.ones((len(x), 1))

    def transform(self, frequency: Floats) -> Floats:
        """Returns the transform of one sample: 1 at all frequencies."""
        return np.ones(np.shape(frequency))


def methods(radar: Radar) -> list[Method]:
    """Returns every method at every setting for a radar; chirp sums only for linear chirps behind a matched filter."""
    sums = chirp_sums(radar) if (radar.modulation, radar.compression) == ("lfm", "matched") else []
    return [*sums, *_grids(radar), *_rates(radar), *_moving(radar)]


def _grids(radar: Radar) -> list[Method]:
    """Returns the methods that grid all echoes of the scan at once."""
    method, rows = partial(Method, radar=radar, first=0.5, reach=None), BALANCED.beam_kernel_width
    compression = compression_for(radar, BALANCED.kernel_width)
    oversampling = radar.sample_rate / radar.bandwidth
    nearest = with_kernel(radar, compression, NearestBin(1, 1.0))
    result = [method("nearest bin", "1 bin", scan_grid(radar, nearest, rows))]
    presets = {(p.kernel_width, p.beam_kernel_width): name for name, p in CORRECTED.items()}
    if isinstance(compression.kernel, PulseKernel):
        # The engine grids a short pulse itself, at every kernel width; the kernels are for comparison
        for across in sorted({p.beam_kernel_width for p in CORRECTED.values()}):
            alike = [name for name, p in CORRECTED.items() if p.beam_kernel_width == across]
            run = scan_grid(radar, compression, across)
            result.append(method("pulse itself", f"{across} rows", run, preset=", ".join(alike)))
        for width in WIDTHS:
            kernel = Kernel(width, max(1.5, oversampling / 4.4))  # as for long pulses
            run = scan_grid(radar, with_kernel(radar, compression, kernel), rows)
            result.append(method("Kaiser-Bessel grid", f"{width} bins", run))
    else:
        for width, across in sorted({(w, rows) for w in WIDTHS} | set(presets)):
            setting = f"{width} bins" + (f" x {across} rows" if across != rows else "")
            run = scan_grid(radar, compression_for(radar, width), across)
            result.append(method("Kaiser-Bessel grid", setting, run, preset=presets.get((width, across))))
    return result


def _rates(radar: Radar) -> list[Method]:
    result = []
    for factor in RATES:
        step = radar.range_step * radar.sample_rate / (factor * radar.bandwidth)
        bins = int(np.ceil(radar.bins * radar.range_step / step - 1e-9))
        other = replace(radar, sample_rate=factor * radar.bandwidth, bins=bins)
        result.append(Method("sampling rate", f"{factor:g} B", gridded(other, BALANCED), other, 0.5, None))
    return result


def _moving(radar: Radar) -> list[Method]:
    """Returns the methods for moving echoes: azimuth by azimuth, with a truncated beam."""
    settings: list[tuple[Fidelity, str | None]]
    settings = [(replace(BALANCED, beam_extent=e), None) for e in EXTENTS if e * radar.beamwidth < np.pi]
    settings += [(preset, f"{name} under way") for name, preset in CORRECTED.items()]
    result = []
    for fidelity, name in sorted(settings, key=lambda pair: pair[0].beam_extent):
        reach = min(np.pi, fidelity.beam_extent * radar.beamwidth)
        setting = f"{fidelity.beam_extent:g} beamwidths" if reach < np.pi else "full circle"
        result.append(Method("azimuth by azimuth", setting, moving_beam(radar, fidelity), radar, 0.5, reach, name))
    return result


def with_kernel(radar: Radar, compression: Compression, kernel: Kernel) -> Compression:
    """Returns the compression for another kernel: the spectra of the waveform over the transform of that kernel."""
    frequency = scipy.fft.fftfreq(compression.size, 1.0 / radar.sample_rate)
    sent, passed = waveform_spectra(radar)
    pulse = radar.sample_rate * sent(frequency) * passed(frequency)
    multiplier = pulse / kernel.transform(frequency / radar.sample_rate)
    return replace(compression, kernel=kernel, echo_filter=multiplier.astype(np.complex64))


def gridded(radar: Radar, fidelity: Fidelity) -> Run:
    """Returns the engine's method for resting echoes at a fidelity."""
    return scan_grid(radar, compression_for(radar, fidelity.kernel_width), fidelity.beam_kernel_width)


def scan_grid(radar: Radar, compression: Compression, across: int) -> Run:
    """Returns a method that grids echoes in azimuth and range, `across` rows each, and filters the scan with the beam."""
    beamwidth = radar.pattern.aperture_beamwidth(radar.beamwidth)
    rows = grid_rows(radar.azimuths, beamwidth)
    kernel = azimuth_kernel(beamwidth, rows, across)
    gain = partial(radar.pattern.gain, beamwidth=radar.beamwidth)

    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        row = echoes.azimuth % (2.0 * np.pi) * (rows / (2.0 * np.pi))
        column = echoes.range / radar.range_step - 0.5
        grid = spread((rows, compression.size), row, column, echoes.amplitude, kernel, compression.kernel)
        scan = beam_filter(grid, gain, kernel, radar.azimuths)
        return np.concatenate([compression.profiles(scan[spokes[i : i + BLOCK]]) for i in range(0, len(spokes), BLOCK)])

    return run


def moving_beam(radar: Radar, fidelity: Fidelity) -> Run:
    """Returns the engine's method for moving echoes at a fidelity.

    It takes a few azimuths at a time and grids the echoes within the extent of the beam in range only.
    """
    compression, count = compression_for(radar, fidelity.kernel_width), min(BLOCK, fidelity.azimuths_per_block)
    extent, span = min(np.pi, fidelity.beam_extent * radar.beamwidth), BLOCK * radar.azimuth_step
    gain = partial(radar.pattern.gain, beamwidth=radar.beamwidth)
    table = BeamTable(gain, radar.beamwidth, extent, span, fidelity.beam_table_oversampling)
    reach = extent + count * radar.azimuth_step / 2.0

    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        blocks = []
        for i in range(0, len(spokes), count):
            boresight = spokes[i : i + count] * radar.azimuth_step
            near = np.flatnonzero(np.abs(wrap_angle(boresight.mean() - echoes.azimuth)) <= reach)
            weight = table(wrap_angle(boresight - echoes.azimuth[near, None]).astype(np.float32))
            amplitude = (weight * echoes.amplitude[near, None]).astype(np.complex64)
            column = echoes.range[near] / radar.range_step - 0.5
            no_migration = np.zeros(amplitude.shape, np.float32)
            grid = np.zeros((len(boresight), compression.size), dtype=np.complex64)
            compression.spread(grid, column, no_migration, amplitude)
            blocks.append(compression.profiles(grid))
        return np.concatenate(blocks)

    return run


def chirp_sums(radar: Radar) -> list[Method]:
    """Returns the chirp sums for a radar that transmits chirps."""

    def pattern(offset: Floats) -> Floats:
        return radar.pattern.gain(offset, radar.beamwidth)

    def printed(offset: Floats) -> Floats:
        return printed_two_way(offset, 0.0, radar.beamwidth, radar.beamwidth_el)

    def method(family: str, extent: float, run: Run, slow: bool = True) -> Method:
        return Method(family, f"{extent:g} beamwidths", run, radar, 0.0, extent * radar.beamwidth, slow=slow)

    methods, reach = [], BOX_BEAMWIDTHS * radar.beamwidth
    as_printed = chirps(radar, reach, printed, chirp_sum)
    methods.append(Method(INTEGER_DELAY, "printed beam", as_printed, radar, 0.0, reach, "documented", slow=True))
    for extent in (BOX_BEAMWIDTHS, 12.0):
        reach = extent * radar.beamwidth
        methods.append(method(INTEGER_DELAY, extent, chirps(radar, reach, pattern, chirp_sum)))
        methods.append(method("integer delays, FFT", extent, chirps(radar, reach, pattern, impulse_sum), slow=False))
        methods.append(method("exact-delay chirps", extent, chirps(radar, reach, pattern, None)))
    return sorted(methods, key=lambda method: method.family)


def chirps(radar: Radar, extent: float, beam: Beam, add: Sum | None) -> Run:
    """Returns the documented chain: it rounds delays to samples, adds chirps and applies one matched filter.

    add: None: each chirp has the exact delay of its echo.
    """
    replica = chirp(pulse_times(radar.pulse, radar.sample_rate), radar.bandwidth, radar.pulse)
    weights = window(radar.window, replica.size)

    def received(distance: Floats, amplitude: Floats, phase: Floats) -> Complexes:
        if add is not None:
            return add(sample_delay(distance, radar.sample_rate), amplitude, phase, replica, radar.bins)
        return exact_chirp_sum(distance, amplitude, phase, radar.bandwidth, radar.pulse, radar.sample_rate, radar.bins)

    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        profiles = np.empty((len(spokes), radar.bins), dtype=np.complex64)
        for k, spoke in enumerate(spokes):
            offset = wrap_angle(spoke * radar.azimuth_step - echoes.azimuth)
            near = np.flatnonzero(np.abs(offset) <= extent)
            amplitude = beam(offset[near]) * echoes.amplitude[near]
            total = received(echoes.range[near], np.abs(amplitude), np.angle(amplitude))
            profiles[k] = compress(total, replica, weights, radar.bins)
        return profiles

    return run
