"""The ports of ASTERIX: each radar has a system identification code (SIC) of its own."""

from collections.abc import Callable, Sequence

from typing_extensions import override

from radar_service.ports.asterix.video_blocks import Form, summary, video
from radar_service.ports.udp.udp_port import Sender, UdpPort
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink


class AsterixPort(UdpPort):
    """Sends what a sink makes of each radar."""

    def __init__(self, name: str, senders: Sequence[Sender], sink: Callable[[UdpPort, int], SpokeSink]) -> None:
        """sink: makes one, of the port and the SIC of a radar."""
        super().__init__(senders)
        self.name, self._sink = name, sink  # type: ignore[misc]
        self._sics: dict[str, int] = {}  # by the id of a radar

    @override
    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        return (self._sink(self, self._sics.setdefault(radar, len(self._sics) % 255 + 1)),)


class VideoSink:
    """The spokes of one radar, and a video summary with the first one of an epoch and of each scan."""

    def __init__(self, port: UdpPort, sic: int, form: Form) -> None:
        self._port, self._form, self._sic = port, form, sic
        self._radar: RadarInfo | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Notes what the next spokes are of."""
        self._radar = radar

    def send(self, batch: SpokeBatch) -> None:
        """Sends spokes; one whose heading is lost is counted as lost."""
        assert self._radar is not None, "open_epoch comes first"
        spokes = list(video(batch, self._form, self._sic))
        begins = batch.first == 0 or batch.block.index == 0
        self._port.lost += spokes.count([])
        self._port.send([summary(self._radar, self._form, self._sic)] * begins + sum(spokes, []))

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Sends nothing: readers see it by the sequence numbers."""

    def close(self, reason: str) -> None:
        """Sends nothing."""
