"""Beacons that answer a radar: racons, which answer by a letter in Morse code, and search and rescue transponders (SARTs).

A beacon answers each pulse that reaches its receiver strongly enough, from the pulse's leading edge on. Figures are those of
Recommendations ITU-R M.628 (SARTs) and M.824 (racons; its sensitivity and time of a sweep as recalled).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from radar_service.numerics import SPEED_OF_LIGHT, Flags, Floats
from radar_service.radar import Radar

X_BAND, S_BAND = (9.3e9, 9.5e9), (2.9e9, 3.1e9)  # Hz, of marine radars
SART_BAND = (9.2e9, 9.5e9)  # Hz, that a SART sweeps over
SART_CYCLES = 12
RETURN_SWEEP, FORWARD_SWEEP = 0.4e-6, 7.5e-6  # s, from the top of the band down and up again
DOT_SPACING = (RETURN_SWEEP + FORWARD_SWEEP) * SPEED_OF_LIGHT / 2.0  # m of range: 0.64 NM
DASH, GAP, LETTER_GAP = 3, 1, 3  # dots
MORSE = {
    "A": ".-", "B": "-...", "C": "-.-.", "D": "-..", "E": ".", "F": "..-.", "G": "--.", "H": "....", "I": "..", "J": ".---",
    "K": "-.-", "L": ".-..", "M": "--", "N": "-.", "O": "---", "P": ".--.", "Q": "--.-", "R": ".-.", "S": "...", "T": "-",
    "U": "..-", "V": "...-", "W": ".--", "X": "-..-", "Y": "-.--", "Z": "--..",
}  # fmt: skip


@dataclass(frozen=True)
class Pulses:
    """The pulses (P,) of an answer.

    begin: after the answer's own beginning [s].
    length: of each [s].
    first, last: carrier where each begins and ends, from the radar's own [Hz]; between them it sweeps evenly.
    """

    begin: Floats
    length: Floats
    first: Floats
    last: Floats

    @property
    def duration(self) -> float:
        """From the beginning of the answer to its end [s]."""
        return float((self.begin + self.length).max())


@dataclass(frozen=True, kw_only=True)
class Beacon(ABC):
    """What racons and SARTs share.

    offset: of its antenna from the origin of the body's frame: starboard, forward, up [m].
    power: radiated in every direction, equivalent isotropic [W].
    sensitivity: the least power of a pulse that triggers it, at an isotropic antenna [W].
    delay: from the leading edge of a pulse to the beginning of the answer [s].
    max_pulse: longest pulse that it takes for a radar's [s]; None: peak power alone decides.
    """

    offset: tuple[float, float, float]
    power: float
    sensitivity: float
    delay: float
    max_pulse: float | None = None

    kind: ClassVar[str]

    def receives(self, frequency: float, pulse: float) -> bool:
        """Whether it receives pulses of a carrier [Hz] and a length [s], whatever their power."""
        in_band = any(low <= frequency <= high for low, high in self.listens)
        return in_band and (self.max_pulse is None or pulse <= self.max_pulse)

    def triggering_range(self, radar: Radar) -> float:
        """Within how far [m] pulses of a radar trigger it at boresight in free space; 0 where it does not take them."""
        if not self.receives(radar.frequency, radar.pulse):
            return 0.0
        reached = radar.power * radar.gain / np.sqrt(radar.loss) / self.sensitivity
        return float(radar.wavelength / (4.0 * np.pi) * np.sqrt(reached))

    @property
    @abstractmethod
    def listens(self) -> tuple[tuple[float, float], ...]:
        """The bands in which it is triggered [Hz]."""

    @abstractmethod
    def active(self, time: Floats) -> Flags:
        """Whether it is switched on at times (K,) [s]."""

    @abstractmethod
    def pulses(self, frequency: float, time: float) -> Pulses:
        """The beacon's answer at `time` [s] to a radar of a carrier `frequency` [Hz]."""

    @property
    def is_steady(self) -> bool:
        """Whether its answer is the same at all times."""
        return True


@dataclass(frozen=True, kw_only=True)
class Racon(Beacon):
    """A radar beacon that answers by letters in Morse code: a dash is three dots, a gap one.

    letters: of the code.
    dot: its length [s].
    bands: in which it answers [Hz].
    tuning_error: of an agile racon's carrier from the radar's [Hz].
    sweep: in which its carrier crosses a band from below, again and again from time 0 on [s]; None: it is agile.
    on, off: how long it answers and is silent by turns, from time 0 on [s]; off = 0: always on.
    """

    letters: str
    dot: float
    bands: tuple[tuple[float, float], ...]
    tuning_error: float = 0.0
    sweep: float | None = None
    on: float = 1.0
    off: float = 0.0

    kind: ClassVar[str] = "racon"

    @property
    def listens(self) -> tuple[tuple[float, float], ...]:
        return self.bands

    @property
    def is_steady(self) -> bool:
        return self.sweep is None

    def active(self, time: Floats) -> Flags:
        return np.asarray((time % (self.on + self.off)) < self.on) if self.off else np.ones(len(time), dtype=np.bool_)

    def pulses(self, frequency: float, time: float) -> Pulses:
        begin, length = morse_marks(self.letters)
        carrier = np.full(len(begin), self.carrier_offset(frequency, time))
        return Pulses(self.dot * begin, self.dot * length, carrier, carrier)

    def carrier_offset(self, frequency: float, time: float) -> float:
        """The offset of the answer's carrier at `time` [s] from that of a radar [Hz]."""
        if self.sweep is None:
            return self.tuning_error
        low, high = next(band for band in self.bands if band[0] <= frequency <= band[1])
        return low + (high - low) * (time / self.sweep % 1.0) - frequency


@dataclass(frozen=True, kw_only=True)
class Sart(Beacon):
    """A search and rescue radar transponder: twelve times a fast sweep down over the band and a slow one up.

    start, end: when it is switched on and off [s]; end None: never off.
    """

    start: float = 0.0
    end: float | None = None

    kind: ClassVar[str] = "sart"

    @property
    def listens(self) -> tuple[tuple[float, float], ...]:
        return (SART_BAND,)

    def active(self, time: Floats) -> Flags:
        return np.asarray((time >= self.start) & (time < (np.inf if self.end is None else self.end)))

    def pulses(self, frequency: float, time: float) -> Pulses:
        cycle = np.arange(SART_CYCLES) * (RETURN_SWEEP + FORWARD_SWEEP)
        begin = np.stack([cycle, cycle + RETURN_SWEEP], axis=-1).ravel()
        low, high = (edge - frequency for edge in SART_BAND)
        pairs = (RETURN_SWEEP, FORWARD_SWEEP), (high, low), (low, high)
        return Pulses(begin, *(np.tile(pair, SART_CYCLES) for pair in pairs))

    @staticmethod
    def first_dot(frequency: float) -> float:
        """When the first slow sweep passes a carrier [Hz], after the answer's beginning [s]."""
        low, high = SART_BAND
        return RETURN_SWEEP + FORWARD_SWEEP * (frequency - low) / (high - low)


def morse_marks(letters: str) -> tuple[Floats, Floats]:
    """Beginnings and lengths (P,) of the dots and dashes of letters, in dots. Raises KeyError for what is no letter."""
    begin, length, at = [], [], 0
    for letter in letters:
        for mark in MORSE[letter]:
            size = 1 if mark == "." else DASH
            begin.append(at)
            length.append(size)
            at += size + GAP
        at += LETTER_GAP - GAP
    return np.array(begin, dtype=np.float64), np.array(length, dtype=np.float64)


def morse_dots(letters: str) -> int:
    """Length of letters in dots."""
    begin, length = morse_marks(letters)
    return int((begin + length).max())


@dataclass(frozen=True, kw_only=True)
class BeaconTruth:
    """A racon or a search and rescue transponder (SART) as the boresight meets its body. Ranges are those of a profile [m].

    kind: "racon" or "sart"; letters: of the Morse code of a racon.
    triggered: whether the radar's pulse reaches it, by line of sight and strong enough, and it answers.
    pulse_dbm: power of the pulse at an isotropic antenna there; answer_dbm: of its answer at the radar's receiver; None: nothing.
    carrier_offset: of a racon's carrier from the radar's [Hz]: out of the receiver's band it is not seen.
    begin, end: ranges of the leading and the trailing edge of the answer, before the receiver's filter.
    dot: length of a racon's dot [m].
    first_dot, dot_spacing: range at which the first slow sweep of a SART passes the radar's carrier, and from there to the next.
    """

    kind: str
    letters: str | None
    triggered: bool
    pulse_dbm: float | None
    answer_dbm: float | None
    carrier_offset: float | None
    begin: float
    end: float
    dot: float | None
    first_dot: float | None
    dot_spacing: float | None
