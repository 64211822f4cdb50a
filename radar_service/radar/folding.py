"""The error of sampled pulses: what lies beyond the sampled band folds into it, and a gridding kernel folds it otherwise.

Sampling at a delay folds each alias Y(f + m fs) of the compressed pulse's spectrum into the band. Gridding keeps Y(f) alone and
adds the kernel's aliases, Y(f) K(f + m fs) / K(f). Over random delays the aliases are independent of each other. The error is
the energy of their differences, as a share of the energy of the sampled pulse.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
import scipy.fft

from radar_service.numerics import Complexes, Floats, kernel_transform, shape_parameter
from radar_service.radar.parameters import Radar
from radar_service.radar.waveform import Chirp

FREQUENCIES = 1024  # in the sampled band, at which spectra are compared
ALIASES = tuple(m for m in range(-4, 5) if m)  # spectra and kernels fall off: further ones change nothing
KERNEL_WIDTHS = (4, 6, 8)  # samples
RATES = (1.1, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0)  # sample rates that are proposed, in bandwidths
LENGTHS = (1.5, 2.0, 3.0, 5.0, 10.0, 20.0)  # pulse lengths that are proposed, in those of the radar


def sampling_error_db(spectrum: Callable[[Floats], Complexes], transform: Callable[[Floats], Floats], rate: float) -> float:
    """Relative field error [dB] of pulses at random delays, spread by a kernel on samples at `rate` [Hz].

    spectrum: of the compressed pulse, a function of frequency [Hz]; transform: of the kernel, of frequency [cycles per sample].
    """
    return _error_db(_band_and_aliases(spectrum, rate), transform)


def _band_and_aliases(spectrum: Callable[[Floats], Complexes], rate: float) -> Complexes:
    """A spectrum (1 + len(ALIASES), FREQUENCIES) in the band that is sampled at `rate` [Hz], and in those of ALIASES."""
    frequency = scipy.fft.fftfreq(FREQUENCIES)
    return np.stack([spectrum((frequency + m) * rate) for m in (0, *ALIASES)])


def _error_db(spectra: Complexes, transform: Callable[[Floats], Floats]) -> float:
    """The error of sampling_error_db, of spectra as _band_and_aliases gives them."""
    frequency, inside = scipy.fft.fftfreq(FREQUENCIES), spectra[0]
    own, error, energy = transform(frequency), 0.0, float(np.sum(np.abs(inside) ** 2))
    for m, folded in zip(ALIASES, spectra[1:], strict=True):
        error += float(np.sum(np.abs(folded - inside * (transform(frequency + m) / own)) ** 2))
        energy += float(np.sum(np.abs(folded) ** 2))
    return float(10.0 * np.log10(error / energy))


def chirp_error_db(radar: Radar, width: int) -> float:
    """Relative field error [dB] of a radar's chirps at random delays, spread by a kernel of `width` samples."""
    chirp = replace(radar.chirp, bandwidth=1.0, pulse=radar.bandwidth * radar.pulse)
    return _chirp_error_db(chirp, radar.sample_rate / radar.bandwidth, width)


def least_chirp_error_db(radar: Radar) -> float:
    """Relative field error [dB] of a radar's chirps at random delays, with the kernel that suits them best."""
    return min(chirp_error_db(radar, width) for width in KERNEL_WIDTHS)


@lru_cache(maxsize=256)
def _chirp_error_db(chirp: Chirp, ratio: float, width: int) -> float:
    """The same for a chirp of unit bandwidth and for sample rate / bandwidth, on which alone it depends."""
    transform = partial(kernel_transform, width=width, beta=shape_parameter(width, ratio))
    return _error_db(_chirp_spectra(chirp, ratio), transform)


@lru_cache(maxsize=16)
def _chirp_spectra(chirp: Chirp, ratio: float) -> Complexes:
    """The spectra of a chirp of unit bandwidth, the same for every kernel."""
    return _band_and_aliases(chirp.compressed, ratio)


def remedies(radar: Radar, error_db: Callable[[Radar], float], limit_db: float) -> str:
    """What brings an error down to `limit_db` [dB], as text: each remedy alone; "" where none does."""
    rates = [ratio * radar.bandwidth for ratio in RATES if ratio * radar.bandwidth > radar.sample_rate]
    lengths = [factor * radar.pulse for factor in LENGTHS]
    changes = [
        [(f"raise sample_rate_hz to {rate:.4g}", replace(radar, sample_rate=rate)) for rate in rates],
        [(f"lengthen pulse_s to {length:.3g}", replace(radar, pulse=length)) for length in lengths],
        [('set window = "hamming"', replace(radar, window="hamming"))] if radar.window == "none" else [],
    ]
    helpful = [next((text for text, changed in kind if error_db(changed) <= limit_db), None) for kind in changes]
    return ", or ".join(text for text in helpful if text is not None)
