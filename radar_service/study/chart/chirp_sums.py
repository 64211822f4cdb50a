"""Sums of chirps azimuth by azimuth: the documented chain, with printed or corrected beam, and with exact delays."""

from collections.abc import Callable

import numpy as np

from radar_service.echo.echoes import Echoes
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Complexes, Floats, Indices, Profiles
from radar_service.radar.parameters import Radar
from radar_service.radar.patterns import printed_two_way
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
from radar_service.study.chart.method import Method, Run
from radar_service.trace.ray_sampling import BOX_BEAMWIDTHS

Sum = Callable[[Indices, Floats, Floats, Complexes, int], Complexes]
Beam = Callable[[Floats], Floats]  # offset from boresight [rad] to the weight of an amplitude
INTEGER_DELAY = "integer-delay chirps"


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
        methods.append(method("exact-delay chirps", extent, exact_chirps(radar, reach, pattern)))
    return sorted(methods, key=lambda each: each.family)


def chirps(radar: Radar, extent: float, beam: Beam, add: Sum) -> Run:
    """Returns the documented chain: it rounds delays to samples, adds chirps and applies one matched filter."""
    replica = chirp(pulse_times(radar.pulse, radar.sample_rate), radar.bandwidth, radar.pulse)
    weights = window(radar.window, replica.size)

    def profile(distance: Floats, amplitude: Complexes) -> Complexes:
        delay = sample_delay(distance, radar.sample_rate)
        received = add(delay, np.abs(amplitude), np.angle(amplitude), replica, radar.bins)
        return compress(received, replica, weights, radar.bins)

    return _each_azimuth(radar, extent, beam, profile)


def exact_chirps(radar: Radar, extent: float, beam: Beam) -> Run:
    """Returns the same chain with each chirp at the exact delay of its echo."""
    replica = chirp(pulse_times(radar.pulse, radar.sample_rate), radar.bandwidth, radar.pulse)
    weights = window(radar.window, replica.size)

    def profile(distance: Floats, amplitude: Complexes) -> Complexes:
        received = exact_chirp_sum(
            distance, np.abs(amplitude), np.angle(amplitude), radar.bandwidth, radar.pulse, radar.sample_rate, radar.bins
        )
        return compress(received, replica, weights, radar.bins)

    return _each_azimuth(radar, extent, beam, profile)


def _each_azimuth(radar: Radar, extent: float, beam: Beam, profile: Callable[[Floats, Complexes], Complexes]) -> Run:
    def run(echoes: Echoes, spokes: Indices) -> Profiles:
        profiles = np.empty((len(spokes), radar.bins), dtype=np.complex64)
        for k, spoke in enumerate(spokes):
            offset = wrap_angle(spoke * radar.azimuth_step - echoes.azimuth)
            near = np.flatnonzero(np.abs(offset) <= extent)
            profiles[k] = profile(echoes.range[near], beam(offset[near]) * echoes.amplitude[near])
        return profiles

    return run
