"""Pulses of other radars that arrive while this one listens: dots and short arcs in spiral rows.

They come straight from antenna to antenna, at their own repetition frequency, and pass the receiver's filter, which is
not matched to them: one made for a long chirp draws a short pulse out over half its own length each side.
"""

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.constants import SPEED_OF_LIGHT
from radar_service.frames import wrap_angle
from radar_service.radar.parameters import Radar
from radar_service.radar.patterns import PATTERNS
from radar_service.random import INTERFERENCE, generator
from radar_service.receive.compression import receiver_noise_power, waveform_spectra
from radar_service.scene.environment import Interferer
from radar_service.scene.world import Scene

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Profiles = NDArray[np.complex64]

AUDIBLE = 1e-3  # of the noise: weaker pulses are left out


@dataclass(frozen=True)
class Arrivals:
    """Pulses that arrive while single azimuths listen, (P,): azimuth row, delay after own pulse [s], amplitude [sqrt(W)]."""

    row: NDArray[np.int64]
    delay: Floats
    amplitude: Complexes


class Interference:
    """One other radar, as this one hears it."""

    def __init__(self, scene: Scene, which: int, seed: int) -> None:
        """which: index in scene.interference."""
        self.scene, self.other = scene, scene.interference[which]
        self._key = (seed, INTERFERENCE, which)
        lag, turn = generator(*self._key, 0).random(2)
        self._first = lag / self.other.prf  # s, of its pulse number 0
        self._start = turn * 2.0 * np.pi  # rad, where it looks at t = 0
        self._power = self.other.level * receiver_noise_power(scene.radar)
        radar, fs = scene.radar, scene.radar.sample_rate
        self._reach = 0.5 * (radar.pulse + self.other.pulse)  # s that a pulse is drawn out each side of its middle
        self._size = int(scipy.fft.next_fast_len(radar.bins + int(np.ceil(4.0 * self._reach * fs))))
        # A digital filter hears the sampled band alone; behind that of a plain pulse the band is sampled, and folds.
        folds = np.arange(-2, 3) if radar.modulation == "none" else np.zeros(1)
        self._frequency = fs * (scipy.fft.fftfreq(self._size) + folds[:, None])
        self._spectrum = fs * unmatched_spectrum(self._frequency, radar, self.other)

    def add(self, profiles: Profiles, boresight: Floats, time: Floats) -> None:
        """Adds what is heard to profiles (K, bins) [sqrt(W)] at boresights [rad] and times [s] (K,)."""
        heard = self.arrivals(boresight, time)
        for row in np.unique(heard.row):
            mine = heard.row == row
            lag = heard.delay[mine] - 0.5 / self.scene.radar.sample_rate  # sample n stands at (n + 1/2) / fs
            spectrum = np.zeros(self._size, dtype=np.complex128)
            for delay, amplitude in zip(lag, heard.amplitude[mine], strict=True):
                spectrum += amplitude * np.sum(np.exp(-2j * np.pi * delay * self._frequency) * self._spectrum, axis=0)
            drawn = scipy.fft.ifft(spectrum)
            profiles[row] += drawn[: profiles.shape[1]]

    def arrivals(self, boresight: Floats, time: Floats) -> Arrivals:
        """Every pulse that is heard at boresights [rad] and times [s] (K,) of own pulses."""
        radar, other = self.scene.radar, self.other
        sent = time if radar.prf is None else np.rint(time * radar.prf) / radar.prf
        window = 2.0 * radar.bins * radar.range_step / SPEED_OF_LIGHT
        begin = np.ceil((sent - self._reach - self._first) * other.prf).astype(np.int64)
        end = np.floor((sent + window + self._reach - self._first) * other.prf).astype(np.int64)
        row = np.repeat(np.arange(len(time)), end - begin + 1)
        pulse = np.concatenate([np.arange(a, b + 1) for a, b in zip(begin, end, strict=True)])
        arrived = self._first + pulse / other.prf
        bearing = self._bearing(time)[row]
        looks = self._start + 2.0 * np.pi * arrived / other.rotation_period
        gain = radar.azimuth_gain(wrap_angle(boresight[row] - bearing))
        gain = gain * PATTERNS["taylor"].gain(wrap_angle(looks - bearing - np.pi), other.beamwidth)
        loud = np.flatnonzero(gain * other.level > AUDIBLE)
        phase = np.array([self._phase(int(p)) for p in pulse[loud]])
        amplitude = np.sqrt(self._power * gain[loud]) * np.exp(1j * phase)
        return Arrivals(row[loud], arrived[loud] - sent[row[loud]], amplitude)

    def _phase(self, pulse: int) -> float:
        """Phase [rad] of a pulse, every time another: magnetrons start anew."""
        return float(generator(*self._key, 1, abs(pulse), int(pulse < 0)).random() * 2.0 * np.pi)

    def _bearing(self, time: Floats) -> Floats:
        """Where the other radar stands (K,) [rad]."""
        if self.other.position is None:
            return np.full(len(time), self.other.bearing)
        antenna = self.scene.antenna(time)
        east, north = self.other.position[0] - antenna[:, 0], self.other.position[1] - antenna[:, 1]
        return np.arctan2(east, north)


def unmatched_spectrum(frequency: Floats, radar: Radar, other: Interferer) -> Complexes:
    """Fourier transform [s] of the other radar's plain pulse of unit amplitude, its middle at delay 0, behind the filter of
    `radar`, at frequencies of any shape [Hz] from own carrier."""
    _, passed = waveform_spectra(radar)
    return np.asarray(other.pulse * np.sinc((frequency - other.frequency_offset) * other.pulse) * passed(frequency))
