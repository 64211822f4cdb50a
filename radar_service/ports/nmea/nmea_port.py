"""The port of NMEA 0183: own ship's sensors as sentences, by TCP and UDP."""

import math
from collections.abc import Mapping, Sequence
from datetime import timedelta

from radar_service.ports.nmea.own_ship import fast_sentences, own_reports, slow_sentences
from radar_service.ports.nmea.targets import target_sentences
from radar_service.ports.udp.udp_port import OneRadarPort, Sender, station_of
from radar_service.service.radio.station import Station
from radar_service.spoke_source import SpokeSourceFault, TellsShips
from radar_service.terminal import UsageError

TENTHS = 10  # instants a second: of the fastest sentence
MAX_LATE = 10 * TENTHS  # instants that are made up for: after a longer leap of time the older ones are left out
ROUNDING = 1e-6  # instants: simulated times are sums


class SentenceSchedule:
    """The instants of a clock that is told the time now and then."""

    def __init__(self) -> None:
        self._last, self._time, self._stood = -1, -math.inf, 0

    def due(self, time: float, begins: float = 0.0) -> list[tuple[int, bool]]:
        """Returns the instants from `begins` to `time` [s] that are due, in tenths of a second, and whether those of seconds are.

        While the time stands, the last one comes again with each call, and with each tenth call that of its second.
        """
        now = math.floor(time * TENTHS + ROUNDING)
        if time == self._time:
            self._stood += 1
            return [(now, self._stood % TENTHS == 0)]
        if time < self._time:  # another scene
            self._last = -1
        first = max(self._last + 1, now - MAX_LATE + 1, math.ceil(begins * TENTHS - ROUNDING))
        self._last, self._time, self._stood = now, time, 0
        return [(instant, instant % TENTHS == 0) for instant in range(first, now + 1)]

    def missed(self, since: int) -> None:
        """Makes the instants from `since` on due again."""
        self._last = min(self._last, since - 1)
        self._time = -math.inf if self._last < 0 else self._last / TENTHS


class SenderPort(OneRadarPort):
    """A port that sends sentences about the ship that carries one radar.

    begins: time of the first ones [s]; needs: options by what they need of the radar, as `Station.lacks` has it.
    """

    period, tells_ships, begins = 1.0 / TENTHS, True, 0.0

    def __init__(self, senders: Sequence[Sender], radar: str | None = None) -> None:
        super().__init__(senders, "--nmea-of", radar)
        self.needs = {"ships": f"--{self.name}-tcp, --{self.name}-udp"}

    def check(self, stations: Mapping[str, Station]) -> None:
        """Raises UsageError also where a replay lacks what sentences need."""
        station = station_of("--nmea-of", stations, self._radar)
        self.begins = station.transmitter.state.simulated
        for what in self.needs.keys() & station.lacks:
            raise UsageError(f"{self.needs[what]}: {station.lacks[what]}")


class NmeaPort(SenderPort):
    """Sentences of own ship's sensors."""

    name = "nmea"

    def __init__(self, senders: Sequence[Sender], radar: str | None = None, tells_truth: bool = False) -> None:
        """tells_truth: whether bodies in sight are sent as targets, too."""
        super().__init__(senders, radar)
        self._tells_truth, self._schedule = tells_truth, SentenceSchedule()
        self.needs |= {"truth": "--nmea-truth"} if tells_truth else {}

    def tick(self, radar: str, time: float) -> None:
        """Sends the sentences that are due."""
        if not self.is_of(radar) or (station := self.station) is None:
            return
        due = self._schedule.due(time, self.begins)
        try:
            lines = self._sentences(station, due) if due else []
        except SpokeSourceFault:  # its process is being replaced: the next tick makes up for it
            self._schedule.missed(due[0][0])
            return
        self.send(lines)

    def _sentences(self, station: Station, due: Sequence[tuple[int, bool]]) -> list[bytes]:
        source = station.epoch.spoke_source
        if not isinstance(source, TellsShips):
            return []
        times, lines = [instant / TENTHS for instant, _ in due], list[bytes]()
        for own, (_, is_second) in zip(own_reports(station, times, station.epoch.info.scene.gnss_offset), due, strict=True):
            lines += fast_sentences(own) + (slow_sentences(own) if is_second else [])
        seconds = [time for time, (_, is_second) in zip(times, due, strict=True) if is_second]
        if self._tells_truth and seconds:
            utc = station.start_utc + timedelta(seconds=seconds[-1])
            lines += target_sentences(source.truth(seconds[-1]), utc, station.epoch.info.scene.origin)
        return lines
