"""Answers of racons and search and rescue transponders (SARTs), as the receiver's filter passes them.

A beacon answers with plain pulses and sweeps. The filter is not matched to them: that of a chirp of length T spreads their edges
over T, and takes as much of their power as lies in its band.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Self

import numpy as np
import scipy.fft

from radar_service.numerics import SPEED_OF_LIGHT, Complexes, Flags, Floats, Indices, generator, name_key
from radar_service.radar import chirp_spectrum
from radar_service.receive import receiver_noise_power, waveform_spectra
from radar_service.records import Fidelity, PlanItem
from radar_service.stages.beacons.beacon import DOT_SPACING, BeaconTruth, Pulses, Racon, Sart
from radar_service.stages.beacons.effect import BeaconEffect
from radar_service.stages.beacons.link import BeaconLink
from radar_service.stages.effect import EffectTruth
from radar_service.stages.stage import Context, Stage, Tile
from radar_service.trace import OcclusionScene
from radar_service.world import Scene

PURPOSE = 26  # the first key of the random phases of answers
MIN_ANSWER_TO_NOISE = 1e-3  # weaker answers are not added
# s, standard deviation of a keyed edge, which rises from 10 to 90 % in 51 ns: sharper ones splash over the band.
EDGE = 20e-9
OUT_OF_BAND = 3.0  # bandwidths: a carrier farther off is not added; there a Gaussian receiver is down by 100 dB


class BeaconTruths(EffectTruth):
    """What the beacons of a scene do as the boresight meets them. Safe to call from several threads."""

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene) -> None:
        self._scene = scene
        self._links = {key: BeaconLink(scene, key, line_of_sight) for key in BeaconEffect().of_bodies(scene)}

    def at_crossing(self, body: int, time: float, boresight: float) -> BeaconTruth | None:
        """The beacon of a body, by its index in the scene, at `time` [s] for a boresight [rad]; None of a body without one."""
        link = self._links.get(body)
        if link is None:
            return None
        radar, beacon, when = self._scene.radar, link.beacon, np.array([time])
        state = link.at(when)
        gain = link.azimuth_gain(state, np.array([boresight]), when)
        reachable = not self._scene.blind(when, np.array([boresight]))[0] and link.visible(time)
        begin = link.delay(state)[0] * SPEED_OF_LIGHT / 2.0
        pulses = beacon.pulses(radar.frequency, time)
        one_way, first_dot = float((state.transfer * gain)[0]), None
        if isinstance(beacon, Sart):
            first_dot = float(begin + beacon.first_dot(radar.frequency) * SPEED_OF_LIGHT / 2.0)
        return BeaconTruth(
            kind=beacon.kind,
            letters=beacon.letters if isinstance(beacon, Racon) else None,
            triggered=bool(reachable and link.triggers(state, gain, when)[0]),
            pulse_dbm=_dbm(radar.power * one_way),
            answer_dbm=_dbm(beacon.power * one_way),
            carrier_offset=beacon.carrier_offset(radar.frequency, time) if isinstance(beacon, Racon) else None,
            begin=float(begin),
            end=float(begin + pulses.duration * SPEED_OF_LIGHT / 2.0),
            dot=beacon.dot * SPEED_OF_LIGHT / 2.0 if isinstance(beacon, Racon) else None,
            first_dot=first_dot,
            dot_spacing=DOT_SPACING if isinstance(beacon, Sart) else None,
        )


def _dbm(power: float) -> float | None:
    """A power [W] in dBm, None for none."""
    return 10.0 * math.log10(power) + 30.0 if power > 0.0 else None


class BeaconAnswers:
    """The answers of one beacon to the pulses of a radar."""

    def __init__(self, scene: Scene, key: int, line_of_sight: OcclusionScene, seed: int) -> None:
        """key: index of the body in the scene."""
        radar = scene.radar
        self.link = BeaconLink(scene, key, line_of_sight)
        self.beacon = self.link.beacon
        self._radar, self._noise = radar, receiver_noise_power(radar)
        self._key = (seed, PURPOSE, name_key(scene.name, scene.bodies[key].name), *scene.random_key)
        # A chirp's filter works on the sampled band. A plain pulse is sampled behind the filter, so the band folds.
        self._folds = np.arange(-2, 3) if radar.modulation == "none" else np.zeros(1)
        duration = self.beacon.pulses(radar.frequency, 0.0).duration
        fs = radar.sample_rate
        self._size = int(scipy.fft.next_fast_len(radar.bins + int(np.ceil((duration + 4.0 * radar.pulse) * fs))))
        self._frequency = fs * (scipy.fft.fftfreq(self._size) + self._folds[:, None])
        self._filter = np.asarray(waveform_spectra(radar)[1](self._frequency))
        self._steady = self._spectrum(0.0) if self.beacon.is_steady else None

    def rows(self, number: Indices, boresight: Floats, time: Floats, transmitting: Flags) -> Iterator[tuple[int, Complexes]]:
        """The answer to each of some azimuths that has one: its row and the profile (bins,) [sqrt(W)].

        number: (K,) of each azimuth, from the start on; boresight: (K,) [rad]; time: (K,) [s]; transmitting: (K,), which
        azimuths are not blind: no other triggers it. They are those of a tile: visibility is that of the strongest one.
        """
        link = self.link.at(time)
        gain = self.link.azimuth_gain(link, boresight, time)
        power = self.beacon.power * link.transfer * gain
        answered = transmitting & self.link.triggers(link, gain, time) & (power > MIN_ANSWER_TO_NOISE * self._noise)
        delay = self.link.delay(link)
        answered &= delay - 0.5 * self._radar.pulse < self._radar.bins / self._radar.sample_rate  # the filter spreads edges
        strongest = int(np.argmax(np.where(answered, power, 0.0)))
        if not answered.any() or not self.link.visible(float(time[strongest])):
            return
        for row in np.flatnonzero(answered).tolist():
            spectrum = self._spectrum(float(time[row])) if self._steady is None else self._steady
            if spectrum is not None:
                phase = generator(*self._key, int(number[row])).random() * 2.0 * np.pi
                amplitude = np.sqrt(power[row]) * np.exp(1j * phase)
                yield row, amplitude * self._received(spectrum, float(delay[row]))

    def _received(self, spectrum: Complexes, delay: float) -> Complexes:
        """The profile (bins,) of an answer of a spectrum as of `_spectrum` that begins at `delay` [s].

        A one-antenna radar hears nothing before it has transmitted the whole pulse; of plain pulses that is not modelled, as of
        their echoes.
        """
        fs, bins, transmitted = self._radar.sample_rate, self._radar.bins, 0.5 * self._radar.pulse
        lag = delay - 0.5 / fs  # the delay of sample n is (n + 1/2) / fs
        shift = np.exp(-2j * np.pi * lag * fs * self._folds)
        if self._radar.eclipsing and self._radar.modulation != "none" and delay < transmitted:
            arriving = scipy.fft.ifft(spectrum[0] * self._delayed(lag))
            arriving[: int(np.ceil(transmitted * fs - 0.5))] = 0.0
            arriving[len(arriving) - int(np.ceil(2.0 * transmitted * fs)) :] = 0.0  # before the middle of the pulse
            received = scipy.fft.fft(arriving) * self._filter[0]
        else:
            received = np.einsum("k,kn,kn->n", shift, spectrum, self._filter) * self._delayed(lag)
        return np.asarray(scipy.fft.ifft(received)[:bins])

    def _delayed(self, lag: float) -> Complexes:
        """What a delay [s] does to the spectrum (size,) of the middle fold."""
        return np.asarray(np.exp(-2j * np.pi * lag * self._frequency[len(self._folds) // 2]))

    def _spectrum(self, time: float) -> Complexes | None:
        """Samples a second times the Fourier transform [s] of the answer at `time` [s], from its beginning on, in all folds
        (folds, size); None where its carrier is out of the receiver's band."""
        pulses = self.beacon.pulses(self._radar.frequency, time)
        low, high = np.minimum(pulses.first, pulses.last), np.maximum(pulses.first, pulses.last)
        if np.all((low > OUT_OF_BAND * self._radar.bandwidth) | (high < -OUT_OF_BAND * self._radar.bandwidth)):
            return None
        return self._radar.sample_rate * answer_spectrum(self._frequency, pulses)


def answer_spectrum(frequency: Floats, pulses: Pulses) -> Complexes:
    """Fourier transform [s] of pulses of unit amplitude at frequencies of any shape [Hz] from the radar's carrier.

    Time 0 is the beginning of the answer, the middle of its first edge. A sweep has the phase 0 where a steady carrier of its
    middle frequency has it.
    """
    total = np.zeros(np.shape(frequency), dtype=np.complex128)
    shapes, which = np.unique(np.stack([pulses.length, pulses.first, pulses.last], axis=-1), axis=0, return_inverse=True)
    for k, (length, first, last) in enumerate(shapes.tolist()):
        off = frequency - (first + last) / 2.0
        if first == last:
            rounded = np.exp(-2.0 * (np.pi * EDGE * off) ** 2)
            shape = np.asarray(length * np.sinc(off * length) * rounded, dtype=np.complex128)
        else:
            shape = chirp_spectrum(off, abs(last - first), length)  # of a sweep up; it is even
            shape = shape if last > first else np.conj(shape)
        middles = pulses.begin[which.reshape(-1) == k] + length / 2.0
        total += shape * sum(np.exp(-2j * np.pi * middle * off) for middle in middles.tolist())
    return total


class BeaconStage(Stage):
    """The answers of all beacons of a scene."""

    def __init__(self, answers: Sequence[BeaconAnswers], numbers: Mapping[str, int]) -> None:
        self._answers, self._numbers = answers, numbers

    @classmethod
    def of(cls, context: Context) -> Self:
        keys = BeaconEffect().of_bodies(context.scene)
        answers = [BeaconAnswers(context.scene, key, context.line_of_sight, context.seed) for key in keys]
        return cls(answers, context.numbers)

    @classmethod
    def plan(cls, scene: Scene, fidelity: Fidelity, microseconds: float | None) -> Sequence[PlanItem]:
        beacons = [(scene.bodies[key].name, beacon) for key, beacon in BeaconEffect().of_bodies(scene).items()]
        kinds = [beacon.kind for _, beacon in beacons]
        count = ", ".join(f"{kinds.count(kind)} {kind}{'s' if kinds.count(kind) > 1 else ''}" for kind in sorted(set(kinds)))
        deaf = [name for name, beacon in beacons if not beacon.receives(scene.radar.frequency, scene.radar.pulse)]
        none = f"; not triggered by this radar's carrier or pulse: {', '.join(deaf)}" if deaf else ""
        how = (
            f"{count}: one-way powers, triggered by the peak power of a pulse, from its leading edge on; exact delays, "
            f"through the filter; none below {10 * math.log10(MIN_ANSWER_TO_NOISE):g} dB of the noise{none}"
        )
        if len(deaf) == len(beacons):
            return [PlanItem("beacons", False, how)]
        omitted = 1.0 + (len(beacons) - len(deaf)) * MIN_ANSWER_TO_NOISE
        error = 10.0 * math.log10(omitted) if scene.environment.noise else None
        return [PlanItem("beacons", True, how, error, microseconds=microseconds)]

    @classmethod
    def truth(cls, scene: Scene, line_of_sight: OcclusionScene) -> BeaconTruths:
        return BeaconTruths(scene, line_of_sight)

    def add(self, tile: Tile) -> None:
        azimuths = tile.azimuths
        for answers in self._answers:
            source = self._numbers[answers.beacon.kind]
            for row, received in answers.rows(azimuths.number, azimuths.boresight, azimuths.time, tile.transmitting):
                tile.add(source, row, received)
