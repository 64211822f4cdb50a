"""Interference: pulses of other radars that arrive while this one receives; dots and short arcs in spiral rows.

They travel directly from antenna to antenna, at their own repetition frequency. The receiver's filter is not matched to them:
the filter of a long chirp widens a short pulse by half the chirp's length each side.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.fft

from radar_service.numerics import SPEED_OF_LIGHT, Complexes, Floats, Indices, generator, wrap_angle
from radar_service.radar import PATTERNS, Radar
from radar_service.receive import receiver_noise_power, waveform_spectra
from radar_service.records import Fidelity, PlanItem
from radar_service.stages.interference.effect import InterferenceEffect, Interferer
from radar_service.stages.registry import changed_pattern
from radar_service.stages.stage import Context, Stage, Tile
from radar_service.world import Scene

PURPOSE = 23  # the first key of its random numbers
MIN_PULSE_TO_NOISE = 1e-3  # weaker pulses are not added


@dataclass(frozen=True)
class Arrivals:
    """Pulses (P,) that arrive while azimuths are received: azimuth row, delay after own pulse [s], amplitude [sqrt(W)]."""

    row: Indices
    delay: Floats
    amplitude: Complexes


class Interference:
    """The pulses of one other radar, as this one receives them."""

    def __init__(self, scene: Scene, index: int, seed: int) -> None:
        """index: of the other radar in the scene."""
        self.scene = scene
        self.other: Interferer = InterferenceEffect().of_scene(scene)[index]
        self._key = (seed, PURPOSE, index)
        lag, circle = generator(*self._key, 0).random(2)
        self._first = lag / self.other.prf  # s, time of its pulse number 0
        self._start = circle * 2.0 * np.pi  # rad, its boresight at t = 0
        self._power = self.other.level * receiver_noise_power(scene.radar)
        radar, fs = scene.radar, scene.radar.sample_rate
        self._half_length = 0.5 * (radar.pulse + self.other.pulse)  # s of a filtered pulse, each side of its middle
        self._size = int(scipy.fft.next_fast_len(radar.bins + int(np.ceil(4.0 * self._half_length * fs))))
        # The filter of a chirp works on the sampled band. A plain pulse is sampled behind the filter, so the band folds.
        folds = np.arange(-2, 3) if radar.modulation == "none" else np.zeros(1)
        self._frequency = fs * (scipy.fft.fftfreq(self._size) + folds[:, None])
        self._spectrum = fs * unmatched_spectrum(self._frequency, radar, self.other)

    def rows(self, boresight: Floats, time: Floats) -> Iterator[tuple[int, Complexes]]:
        """Row and profile (bins,) [sqrt(W)] of each azimuth that receives pulses, at boresights [rad] and times [s] (K,)."""
        arrivals = self.arrivals(boresight, time)
        for row in np.unique(arrivals.row):
            in_row = arrivals.row == row
            lag = arrivals.delay[in_row] - 0.5 / self.scene.radar.sample_rate  # the delay of sample n is (n + 1/2) / fs
            spectrum = np.zeros(self._size, dtype=np.complex128)
            for delay, amplitude in zip(lag, arrivals.amplitude[in_row], strict=True):
                spectrum += amplitude * np.sum(np.exp(-2j * np.pi * delay * self._frequency) * self._spectrum, axis=0)
            yield int(row), scipy.fft.ifft(spectrum)[: self.scene.radar.bins]

    def arrivals(self, boresight: Floats, time: Floats) -> Arrivals:
        """All received pulses at boresights [rad] and times [s] (K,) of own pulses."""
        radar, other = self.scene.radar, self.other
        transmitted = time if radar.prf is None else np.rint(time * radar.prf) / radar.prf
        window = 2.0 * radar.bins * radar.range_step / SPEED_OF_LIGHT
        begin = np.ceil((transmitted - self._half_length - self._first) * other.prf).astype(np.int64)
        end = np.floor((transmitted + window + self._half_length - self._first) * other.prf).astype(np.int64)
        row = np.repeat(np.arange(len(time)), end - begin + 1)
        pulse = np.concatenate([np.arange(a, b + 1) for a, b in zip(begin, end, strict=True)])
        arrived = self._first + pulse / other.prf
        bearing = self._bearing(time)[row]
        other_boresight = self._start + 2.0 * np.pi * arrived / other.rotation_period
        gain = self._gain(bearing, boresight[row], time[row])
        gain = gain * PATTERNS["taylor"].gain(wrap_angle(other_boresight - bearing - np.pi), other.beamwidth)
        strong = np.flatnonzero(gain * other.level > MIN_PULSE_TO_NOISE)
        phase = np.array([self._phase(int(p)) for p in pulse[strong]])
        amplitude = np.sqrt(self._power * gain[strong]) * np.exp(1j * phase)
        return Arrivals(row[strong], arrived[strong] - transmitted[row[strong]], amplitude)

    def _gain(self, bearing: Floats, boresight: Floats, time: Floats) -> Floats:
        """One-way power gain (P,) towards the other radar at bearings, boresights [rad] and times [s] (P,)."""
        pattern = changed_pattern(self.scene.radar)
        if pattern is None:
            return self.scene.radar.azimuth_gain(wrap_angle(boresight - bearing))
        field = pattern.one_way(bearing - self.scene.platform.heading(time), bearing - boresight)
        return np.abs(field) ** 2

    def _phase(self, pulse: int) -> float:
        """Random phase [rad] of a pulse: a magnetron starts each pulse with a new one."""
        return float(generator(*self._key, 1, abs(pulse), int(pulse < 0)).random() * 2.0 * np.pi)

    def _bearing(self, time: Floats) -> Floats:
        """Bearing of the other radar (K,) [rad]."""
        if self.other.position is None:
            return np.full(len(time), self.other.bearing)
        antenna = self.scene.antenna(time)
        east, north = self.other.position[0] - antenna[:, 0], self.other.position[1] - antenna[:, 1]
        return np.arctan2(east, north)


def unmatched_spectrum(frequency: Floats, radar: Radar, other: Interferer) -> Complexes:
    """Fourier transform [s] of the other radar's plain pulse of unit amplitude, its middle at delay 0, behind the filter of
    `radar`, at frequencies of any shape [Hz] from own carrier."""
    _, filtered = waveform_spectra(radar)
    return np.asarray(other.pulse * np.sinc((frequency - other.frequency_offset) * other.pulse) * filtered(frequency))


class InterferenceStage(Stage):
    """The pulses of all other radars of a scene, which a blind sector does not stop."""

    def __init__(self, radars: Sequence[Interference], source: int) -> None:
        self.radars, self._source = radars, source

    @classmethod
    def of(cls, context: Context) -> Self:
        count = len(InterferenceEffect().of_scene(context.scene))
        radars = [Interference(context.scene, index, context.seed) for index in range(count)]
        return cls(radars, context.numbers["interference"])

    def add(self, tile: Tile) -> None:
        for other in self.radars:
            for row, received in other.rows(tile.azimuths.boresight, tile.azimuths.time):
                tile.add(self._source, row, received)

    @classmethod
    def plan(cls, scene: Scene, fidelity: Fidelity, microseconds: float | None) -> Sequence[PlanItem]:
        count = len(InterferenceEffect().of_scene(scene))
        how = f"{count} other radar{'s' if count > 1 else ''}, each pulse at its time through both beams and the filter"
        return [PlanItem("interference", True, how, microseconds=microseconds)]
