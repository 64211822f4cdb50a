"""Methods of the signal chain, from the documented chirp sum to the engine's grid: the same echoes in, profiles out."""

from dataclasses import replace
from functools import partial

import numpy as np
import scipy.fft

from radar_service.echo.range_history import TABLE_STEPS, BeamTable
from radar_service.fidelity import PRESETS, Fidelity
from radar_service.frames import wrap_angle
from radar_service.propagation.radar_equation import Echoes
from radar_service.radar.antenna import grid_rows
from radar_service.radar.parameters import Radar
from radar_service.receive.beam import azimuth_kernel, sweep
from radar_service.receive.compression import Compression, compression_for, waveform_spectra
from radar_service.receive.gridding import Kernel, spread, spread_moving
from radar_service.receive.plain_pulse import PulseKernel
from radar_service.study.chart.chirp_sums import chirp_sums
from radar_service.study.chart.method import TILE, Floats, Indices, Method, Profiles, Run

BALANCED = PRESETS["balanced"]
CORRECTED = {name: preset for name, preset in PRESETS.items() if preset.engine == "corrected"}
WIDTHS = (2, 4, 6, 8)  # range bins that an echo is laid on
RATES = (1.0, 1.25, 2.0, 4.0)  # samples a second over the bandwidth
EXTENTS = (1.5, 6.0, 24.0)  # beamwidths each side, beside those of the presets


class NearestBin(Kernel):
    """No kernel: an echo goes to the bin it is in."""

    def weights(self, x: Floats) -> tuple[Indices, Floats]:
        """The nearest sample (E,) and weight 1 (E, 1)."""
        return np.rint(x).astype(np.int64), np.ones((len(x), 1))

    def transform(self, frequency: Floats) -> Floats:
        """A single sample's: 1 at all frequencies."""
        return np.ones(np.shape(frequency))


def methods(radar: Radar) -> list[Method]:
    """Every method at every setting for a radar; sums of chirps only where it sends chirps."""
    sums = chirp_sums(radar) if radar.modulation == "lfm" else []
    return [*sums, *_grids(radar), *_rates(radar), *_swept(radar)]


def _grids(radar: Radar) -> list[Method]:
    """Echoes laid once for the whole turn."""
    plain, rows = partial(Method, radar=radar, first=0.5, reach=None), BALANCED.beam_kernel_width
    usual, exact = compression_for(radar, BALANCED.kernel_width), gridded(radar, BALANCED)
    oversampling = radar.sample_rate / radar.bandwidth
    found = [plain("nearest bin", "1 bin", laid_on(radar, with_kernel(radar, usual, NearestBin(1, 1.0)), rows))]
    presets = {(p.kernel_width, p.beam_kernel_width): name for name, p in CORRECTED.items()}
    if isinstance(usual.kernel, PulseKernel):
        # A short pulse is laid as it is, whatever width a preset asks for; kernels are then there to be compared with it
        for across in sorted({p.beam_kernel_width for p in CORRECTED.values()}):
            alike = [name for name, p in CORRECTED.items() if p.beam_kernel_width == across]
            found.append(plain("pulse itself", f"{across} rows", laid_on(radar, usual, across), preset=", ".join(alike)))
        for width in WIDTHS:
            made = with_kernel(radar, usual, Kernel(width, max(1.5, oversampling / 4.4)))  # as for long pulses
            found.append(plain("Kaiser-Bessel grid", f"{width} bins", laid_on(radar, made, rows)))
    else:
        for width, across in sorted({(w, rows) for w in WIDTHS} | set(presets)):
            setting = f"{width} bins" + (f" x {across} rows" if across != rows else "")
            run = laid_on(radar, compression_for(radar, width), across)
            found.append(plain("Kaiser-Bessel grid", setting, run, preset=presets.get((width, across))))
    found.append(plain("precision of range", "float64", exact))
    found.append(plain("precision of range", "float32", in_single(exact, radar.wavelength)))
    return found


def _rates(radar: Radar) -> list[Method]:
    found = []
    for factor in RATES:
        step = radar.range_step * radar.sample_rate / (factor * radar.bandwidth)
        bins = int(np.ceil(radar.bins * radar.range_step / step - 1e-9))
        other = replace(radar, sample_rate=factor * radar.bandwidth, bins=bins)
        found.append(Method("sampling rate", f"{factor:g} B", gridded(other, BALANCED), other, 0.5, None))
    return found


def _swept(radar: Radar) -> list[Method]:
    """As moving echoes are laid: azimuth by azimuth, the beam cut."""
    tried: list[tuple[Fidelity, str | None]]
    tried = [(replace(BALANCED, beam_extent=e), None) for e in EXTENTS if e * radar.beamwidth < np.pi]
    tried += [(preset, f"{name} under way") for name, preset in CORRECTED.items()]
    found = []
    for fidelity, name in sorted(tried, key=lambda pair: pair[0].beam_extent):
        reach = min(np.pi, fidelity.beam_extent * radar.beamwidth)
        setting = f"{fidelity.beam_extent:g} beamwidths" if reach < np.pi else "full circle"
        found.append(Method("azimuth by azimuth", setting, swept(radar, fidelity), radar, 0.5, reach, name))
    return found


def with_kernel(radar: Radar, compression: Compression, kernel: Kernel) -> Compression:
    """The same compression for echoes laid with another kernel: the waveform's spectra over that kernel's transform."""
    frequency = scipy.fft.fftfreq(compression.size, 1.0 / radar.sample_rate)
    sent, passed = waveform_spectra(radar)
    pulse = radar.sample_rate * sent(frequency) * passed(frequency)
    multiplier = pulse / kernel.transform(frequency / radar.sample_rate)
    return replace(compression, kernel=kernel, echo_multiplier=multiplier.astype(np.complex64))


def gridded(radar: Radar, fidelity: Fidelity) -> Run:
    """The engine's way for what rests at a fidelity."""
    return laid_on(radar, compression_for(radar, fidelity.kernel_width), fidelity.beam_kernel_width)


def laid_on(radar: Radar, compression: Compression, across: int) -> Run:
    """Echoes laid once on azimuth x range, on `across` rows each; one beam for the whole turn."""
    beamwidth = radar.pattern.aperture_beamwidth(radar.beamwidth)
    rows = grid_rows(radar.azimuths, beamwidth)
    kernel = azimuth_kernel(beamwidth, rows, across)
    pattern = partial(radar.pattern.gain, beamwidth=radar.beamwidth)

    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        row = echoes.azimuth % (2.0 * np.pi) * (rows / (2.0 * np.pi))
        column = echoes.range / radar.range_step - 0.5
        grid = spread((rows, compression.size), row, column, echoes.amplitude, kernel, compression.kernel)
        turn = sweep(grid, pattern, kernel, radar.azimuths)
        return np.concatenate([compression.profiles(turn[spokes[i : i + TILE]]) for i in range(0, len(spokes), TILE)])

    return run


def swept(radar: Radar, fidelity: Fidelity) -> Run:
    """The engine's way for what moves at a fidelity: laid along range alone, for each few azimuths the echoes within the
    beam's extent."""
    compression, combine_db = compression_for(radar, fidelity.kernel_width), min(TILE, fidelity.azimuths_per_block)
    pattern = partial(radar.pattern.gain, beamwidth=radar.beamwidth)
    extent, span = min(np.pi, fidelity.beam_extent * radar.beamwidth), TILE * radar.azimuth_step
    table = BeamTable(pattern, radar.beamwidth, extent, span, fidelity.beam_table_oversampling * TABLE_STEPS)
    reach = extent + combine_db * radar.azimuth_step / 2.0

    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        tiles = []
        for i in range(0, len(spokes), combine_db):
            boresight = spokes[i : i + combine_db] * radar.azimuth_step
            near = np.flatnonzero(np.abs(wrap_angle(boresight.mean() - echoes.azimuth)) <= reach)
            weight = table(wrap_angle(boresight - echoes.azimuth[near, None]).astype(np.float32))
            amplitude = (weight * echoes.amplitude[near, None]).astype(np.complex64)
            column = echoes.range[near] / radar.range_step - 0.5
            still = np.zeros(amplitude.shape, np.float32)
            gridded = np.zeros((len(boresight), compression.size), dtype=np.complex64)
            spread_moving(gridded, column, still, amplitude, compression.tables)
            tiles.append(compression.profiles(gridded))
        return np.concatenate(tiles)

    return run


def in_single(run: Run, wavelength: float) -> Run:
    """The same with ranges, and so phases, that a float32 holds: what trusting a ray tracer's distance would do."""

    def rounded(echoes: Echoes, spokes: Indices) -> Profiles:
        single = echoes.range.astype(np.float32).astype(np.float64)
        phase = np.exp(-4j * np.pi / wavelength * (single - echoes.range))
        return run(Echoes(single, echoes.azimuth, echoes.amplitude * phase), spokes)

    return rounded
