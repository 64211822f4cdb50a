"""A pulse without modulation, as magnetrons transmit it, behind a Gaussian receiver filter: closed forms in time.

The filter models the tuned stages of a receiver; its half-power bandwidth is the radar's. A unit echo has a unit peak. The
response is about as short as the pulse, so the response itself is the gridding kernel, and no transform is needed.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from radar_service.numerics import BOLTZMANN, REFERENCE_TEMPERATURE, Complexes, Flags, Floats, Indices
from radar_service.radar import Radar
from radar_service.receive.gridding import Kernel

TAIL = 5.0  # standard deviations of the filter's response: beyond them it is below -120 dB of the peak


def filter_sigma(bandwidth: float) -> float:
    """Standard deviation [s] of the impulse response of a Gaussian filter of half-power `bandwidth` [Hz]: 0.265 / B."""
    return float(np.sqrt(np.log(2.0)) / (np.pi * bandwidth))


def plain_response(delay: Floats, pulse: float, bandwidth: float, received_from: Floats | float = -np.inf) -> Floats:
    """Filter output of a unit echo at `delay` [s] from its middle, 1 at 0: the difference of two error functions.

    received_from: time within the echo, from its middle, before which it is eclipsed [s]; broadcast against delay.
    """
    root = np.sqrt(2.0) * filter_sigma(bandwidth)
    begin = np.clip(received_from, -pulse / 2.0, pulse / 2.0)
    response = erf((delay - begin) / root) - erf((delay - pulse / 2.0) / root)
    return np.asarray(response / (2.0 * erf(pulse / 2.0 / root)))


def plain_filter_power(frequency: Floats, bandwidth: float) -> Floats:
    """|H|^2 of the filter at `frequency` [Hz] from the carrier: 1 in the middle, 1/2 at +-B/2."""
    return np.asarray(np.exp(-4.0 * np.log(2.0) * (frequency / bandwidth) ** 2))


def plain_spectrum(frequency: Floats, pulse: float) -> Complexes:
    """Fourier transform [s] of the rectangular pulse at `frequency` [Hz]."""
    return np.asarray(pulse * np.sinc(frequency * pulse), dtype=np.complex128)


def plain_filter(frequency: Floats, pulse: float, bandwidth: float) -> Complexes:
    """Transfer function of the filter at `frequency` [Hz], scaled so that a unit echo has a unit peak."""
    peak = erf(pulse / 2.0 / (np.sqrt(2.0) * filter_sigma(bandwidth)))
    return np.asarray(np.sqrt(plain_filter_power(frequency, bandwidth)) / peak, dtype=np.complex128)


def plain_noise_power(pulse: float, bandwidth: float, noise_factor: float) -> float:
    """Power [W] of filtered white receiver noise where a unit echo peaks at 1.

    k T0 F times the noise bandwidth 1.0645 B over the square of the filter's peak response; the best B T is 0.73, half
    a decibel below the matched filter (Skolnik 2001, table of non-matched filters).
    """
    noise_bandwidth = bandwidth * np.sqrt(np.pi / (4.0 * np.log(2.0)))
    peak = erf(pulse / 2.0 / (np.sqrt(2.0) * filter_sigma(bandwidth)))
    return float(BOLTZMANN * REFERENCE_TEMPERATURE * noise_factor * noise_bandwidth / peak**2)


@dataclass(frozen=True)
class PulseKernel(Kernel):
    """The filtered pulse itself as gridding kernel, so that its transform needs no correction.

    pulse: its length [samples].
    bandwidth: of the filter [per sample].
    eclipsing: whether nothing is received before the end of the own pulse.
    """

    pulse: float = 0.0
    bandwidth: float = 1.0
    eclipsing: bool = False

    def weights(self, x: Floats) -> tuple[Indices, Floats]:
        """First sample (E,) and weights (E, width) of points at positions x (E,) [samples], without what is eclipsed."""
        first, weights = super().weights(x)
        near = np.flatnonzero(self.clips(x))
        offset = (first[near] - x[near])[:, None] + np.arange(self.width)
        received_from = self.pulse / 2.0 - (x[near] + 0.5)  # column x has a delay of x + 1/2 samples
        weights[near] = plain_response(offset, self.pulse, self.bandwidth, received_from[:, None])
        return first, weights

    def clips(self, x: Floats) -> Flags:
        """Which echoes at positions x [samples] are partly or fully eclipsed."""
        return np.asarray((x + 0.5 < self.pulse) & self.eclipsing)

    def transform(self, frequency: Floats) -> Floats:
        """1 at every frequency: the gridded response needs no further filter."""
        return np.ones_like(frequency)

    def _value(self, offset: Floats) -> Floats:
        return plain_response(offset, self.pulse, self.bandwidth)


def pulse_kernel(radar: Radar) -> PulseKernel:
    """The kernel of a radar without modulation, as wide as the pulse and the tails of the filter."""
    half_width = radar.pulse / 2.0 + TAIL * filter_sigma(radar.bandwidth)
    width = 2 * int(np.ceil(half_width * radar.sample_rate))
    return PulseKernel(width, 1.0, radar.pulse * radar.sample_rate, radar.bandwidth / radar.sample_rate, radar.eclipsing)
