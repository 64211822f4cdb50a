"""A port that sends datagrams, or what else does not wait: what is lost is counted as dropped by its thread."""

import contextlib
from collections.abc import Mapping, Sequence
from typing import Protocol

from radar_service.ports.port import Port, Service
from radar_service.service.radio.station import Station, Stations
from radar_service.terminal import UsageError


class Sender(Protocol):
    """Takes pieces: sentences, or datagrams. lost: of those that could not go out; `send` and `close` belong to one thread."""

    lost: int

    def send(self, pieces: Sequence[bytes]) -> None:
        """Sends pieces to whoever is there, without waiting; an empty list lets others connect."""

    def close(self) -> None:
        """Closes its sockets."""


class UdpPort(Port):
    """A port with senders. lost: what it did not hand to any of them."""

    def __init__(self, senders: Sequence[Sender]) -> None:
        self.senders, self.lost = senders, 0
        self._counted = 0

    def close(self) -> None:
        """Closes all senders."""
        for sender in self.senders:
            with contextlib.suppress(OSError):
                sender.close()

    def send(self, pieces: Sequence[bytes]) -> None:
        """Sends pieces by all senders, and counts those that did not go out as dropped."""
        for sender in self.senders:
            sender.send(pieces)
        self.note_lost(0)

    def note_lost(self, count: int) -> None:
        """Counts what was not handed to a sender, and what senders have lost since the last call, as dropped."""
        self.lost += count
        lost = self.lost + sum(sender.lost for sender in self.senders)
        if self.thread is not None and lost > self._counted:
            self.thread.note_dropped(lost - self._counted)
        self._counted = lost


class OneRadarPort(UdpPort):
    """A port about one radar: the first one, or `radar` while it is there."""

    def __init__(self, senders: Sequence[Sender], option: str, radar: str | None) -> None:
        """option: that names the radar."""
        super().__init__(senders)
        self._option, self._radar, self._stations = option, radar, Stations()

    def check(self, stations: Mapping[str, Station]) -> None:
        """Looks for the radar."""
        station_of(self._option, stations, self._radar)

    async def start(self, service: Service) -> None:
        """Notes the radars."""
        self._stations = service.stations

    @property
    def station(self) -> Station | None:
        """The radar, None while it is not there."""
        return self._stations.of(self._radar)

    def is_of(self, radar: str) -> bool:
        """Returns whether it is the radar of that id."""
        return self.station is not None and self.station.identity == radar


def station_of(option: str, stations: Mapping[str, Station], radar: str | None) -> Station:
    """Returns the radar of that id, by default the first one. Raises UsageError where the service has no such radar."""
    if radar not in (None, *stations):
        raise UsageError(f"{option}: {radar} is no radar of this service; it has {', '.join(stations)}")
    return stations[radar or next(iter(stations))]
