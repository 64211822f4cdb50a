"""Reads NMEA 0183: bytes of strangers in, what their sentences say out. No clock and no socket; memory is bounded.

Fields as in the table of `docs/connect.md`. Angles stay degrees, speeds knots, as commands have them.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from radar_service.ports.nmea.sentences import checksum

MAX_LINE = 256  # bytes; a sentence has at most 82
GNSS = frozenset("GP GN GL GA GB BD GI GQ".split())
HEADING = frozenset("HE HN HC HF".split())
INTEGRATED = frozenset("II IN EC TR".split())  # bridge, navigation, chart display, simulators
TALKERS = GNSS | HEADING | INTEGRATED
SENTENCE = re.compile(r"[$!]([A-Z]{2})([A-Z]{3}),([ -~]*)\*([0-9A-Fa-f]{2})")
NUMBER = re.compile(r"\d{1,6}(?:\.\d{0,12})?")
PLACE = re.compile(r"(\d{2,3})(\d{2}(?:\.\d{0,12})?)")
CLOCK = re.compile(r"([01]\d|2[0-3])([0-5]\d)([0-5]\d(?:\.\d{0,6})?)")


class SentenceIgnoredError(Exception):
    """A sentence that is not followed. Its text is a word for the reason, which counts have."""


@dataclass(frozen=True)
class Reading:
    """What a sentence says; None: nothing of that kind.

    heading_deg, course_deg: [0, 360]; speed_kn: over ground.
    position: latitude and longitude [degrees, WGS 84].
    clock: UTC since midnight [s].
    """

    heading_deg: float | None = None
    course_deg: float | None = None
    speed_kn: float | None = None
    position: tuple[float, float] | None = None
    clock: float | None = None

    @property
    def motion(self) -> dict[str, float]:
        """Heading, course and speed by the keys of a command, those that are known."""
        values = {"heading_deg": self.heading_deg, "course_deg": self.course_deg, "speed_kn": self.speed_kn}
        return {key: value for key, value in values.items() if value is not None}


def read(line: bytes) -> Reading:
    """Returns what a line without its end says. Raises SentenceIgnoredError: form, checksum, kind, talker, value, invalid."""
    form = SENTENCE.fullmatch(line.decode("ascii", "replace")) if len(line) <= MAX_LINE else None
    if form is None:
        raise SentenceIgnoredError("form")
    talker, kind, fields, given = form.groups()
    if checksum(f"{talker}{kind},{fields}") != int(given, 16):
        raise SentenceIgnoredError("checksum")
    if kind not in KINDS:
        raise SentenceIgnoredError("kind")
    if talker not in TALKERS:
        raise SentenceIgnoredError("talker")
    count, reader = KINDS[kind]
    values = fields.split(",")
    if len(values) < count:
        raise SentenceIgnoredError("value")
    return reader(values)


def _hdt(fields: Sequence[str]) -> Reading:
    _check(fields[1] == "T", "value")
    return Reading(heading_deg=_needed(_bearing(fields[0])))


def _ths(fields: Sequence[str]) -> Reading:
    _check(fields[1] != "V", "invalid")
    return Reading(heading_deg=_needed(_bearing(fields[0])))


def _vtg(fields: Sequence[str]) -> Reading:
    _check(fields[8:9] != ["N"], "invalid")
    _check(fields[1] == "T" and fields[5] == "N", "value")
    return Reading(course_deg=_bearing(fields[0]), speed_kn=_needed(_number(fields[4])))


def _rmc(fields: Sequence[str]) -> Reading:
    _check(fields[1] == "A" and fields[11:12] != ["N"], "invalid")
    place = _position(fields[2:6])
    return Reading(None, _bearing(fields[7]), _number(fields[6]), place, _clock(fields[0]))


def _gga(fields: Sequence[str]) -> Reading:
    _check(fields[5] not in ("", "0"), "invalid")
    return Reading(position=_position(fields[1:5]), clock=_clock(fields[0]))


KINDS: Mapping[str, tuple[int, Callable[[Sequence[str]], Reading]]] = {  # by the fewest fields
    "HDT": (2, _hdt), "THS": (2, _ths), "VTG": (8, _vtg), "RMC": (9, _rmc), "GGA": (6, _gga),
}  # fmt: skip


def _check(holds: bool, reason: str) -> None:
    if not holds:
        raise SentenceIgnoredError(reason)


def _number(text: str, highest: float = 1e6) -> float | None:
    """A number from 0 to the highest one, None for an empty field."""
    if not text:
        return None
    _check(NUMBER.fullmatch(text) is not None and float(text) <= highest, "value")
    return float(text)


def _bearing(text: str) -> float | None:
    return _number(text, 360.0)


def _needed(value: float | None) -> float:
    if value is None:
        raise SentenceIgnoredError("invalid")  # as a sensor that has lost it says
    return value


def _clock(text: str) -> float:
    form = CLOCK.fullmatch(text)
    if form is None:
        raise SentenceIgnoredError("value")
    return 3600.0 * int(form[1]) + 60.0 * int(form[2]) + float(form[3])


def _position(fields: Sequence[str]) -> tuple[float, float]:
    latitude, north_south, longitude, east_west = fields
    return _degrees(latitude, north_south, "NS", 90.0), _degrees(longitude, east_west, "EW", 180.0)


def _degrees(text: str, side: str, sides: str, highest: float) -> float:
    """Degrees of dddmm.mmm, positive on the first side."""
    form = PLACE.fullmatch(text)
    if form is None or side not in tuple(sides) or float(form[2]) >= 60.0:
        raise SentenceIgnoredError("value")
    angle = int(form[1]) + float(form[2]) / 60.0
    _check(angle <= highest, "value")
    return angle if side == sides[0] else -angle


class SentenceLines:
    """The lines of one stream.

    too_long: how many had no end within MAX_LINE bytes, and were left out; rest: the one that has no end yet.
    """

    def __init__(self) -> None:
        self.too_long = 0
        self.rest, self._skips = b"", False

    def of(self, data: bytes) -> list[bytes]:
        """Returns the lines that end in the bytes which came next; of an unfinished one it keeps at most MAX_LINE bytes."""
        *complete, self.rest = (self.rest + data).split(b"\n")
        if complete and self._skips:
            del complete[0]
            self._skips = False
        if len(self.rest) > MAX_LINE and not self._skips:
            self.too_long += 1
            self._skips = True
        if self._skips:
            self.rest = b""
        return [line for each in complete if (line := each.rstrip(b"\r"))]
