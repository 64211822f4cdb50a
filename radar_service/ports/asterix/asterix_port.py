"""The ports of ASTERIX: each radar has a system identification code (SIC) of its own."""

import asyncio
import contextlib
from collections.abc import Callable, Sequence
from functools import partial

from radar_service.plots import Extract, LivePlots, Plot, PlotProcess, extraction
from radar_service.ports.asterix.blocks import Form, plot_blocks, summary, video
from radar_service.ports.port import Service
from radar_service.ports.udp.udp_port import Sender, UdpPort
from radar_service.processes.fork_server import ForkServer
from radar_service.service.logs import log_event
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink

PATIENCE = 0.8  # s for the scans that a process still has at the end: a port has a second
GONE = "the process of plots was killed or ran out of memory; the next scan begins another: if it goes too, free memory"


class AsterixPort(UdpPort):
    """Sends the video of all radars."""

    name = "asterix"

    def __init__(self, senders: Sequence[Sender], form: Form) -> None:
        super().__init__(senders)
        self.form = form
        self._sics: dict[str, int] = {}  # by the id of a radar

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        """Returns the sink of a radar."""
        return (self.sink(self.sic(radar)),)

    def sic(self, radar: str) -> int:
        """Returns the code of a radar."""
        return self._sics.setdefault(radar, len(self._sics) % 255 + 1)

    def sink(self, sic: int) -> SpokeSink:
        """Returns a sink for the spokes of one radar."""
        return VideoSink(self, sic, self.form)


class VideoSink(SpokeSink):
    """The spokes of one radar, and a video summary with the first one of an epoch and of each scan."""

    def __init__(self, port: UdpPort, sic: int, form: Form) -> None:
        self._port, self._form, self._sic = port, form, sic
        self._radar: RadarInfo | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Notes the radar."""
        self._radar = radar

    def send(self, batch: SpokeBatch) -> None:
        """Sends spokes, or plots."""
        assert self._radar is not None, "open_epoch comes first"
        spokes = list(video(batch, self._form, self._sic))
        begins = batch.first == 0 or batch.block.index == 0
        self._port.note_lost(spokes.count([]))  # their heading is lost
        self._port.send([summary(self._radar, self._form, self._sic)] * begins + sum(spokes, []))


class PlotPort(AsterixPort):
    """Sends the plots of all radars."""

    name, period = "asterix-plots", 0.1

    def __init__(self, senders: Sequence[Sender], form: Form) -> None:
        super().__init__(senders, form)
        self._fork_server: ForkServer | None = None
        self._by_radar: dict[str, PlotSink] = {}

    async def start(self, service: Service) -> None:
        """Notes what starts processes."""
        self._fork_server = service.fork_server

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        """Returns the sink of a radar."""
        self._by_radar[radar] = self.sink(self.sic(radar))
        return (self._by_radar[radar],)

    def sink(self, sic: int) -> "PlotSink":
        """Returns a sink of plots."""
        return PlotSink(self, sic, self.form.sac, lambda: self._fork_server)

    async def stop(self) -> None:
        """Sends the plots that come soon, and ends the processes."""
        for sink in self._by_radar.values():
            await asyncio.to_thread(sink.close, "the service stops")

    def tick(self, radar: str, time: float) -> None:
        """Sends the plots that have come."""
        self._by_radar[radar].look()


class PlotSink(SpokeSink):
    """The plots of one radar, after each scan. In a service a process extracts them, and no spoke waits for it."""

    def __init__(self, port: UdpPort, sic: int, sac: int, server: Callable[[], ForkServer | None] = lambda: None) -> None:
        """server: starts the process; without one `send` extracts."""
        self._port, self._sac, self._sic, self._server = port, sac, sic, server
        self._radar: RadarInfo | None = None
        self._plots: LivePlots | None = None
        self._process: PlotProcess | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Notes the radar."""
        self.close("another epoch")
        self._radar = radar

    def send(self, batch: SpokeBatch) -> None:
        """Sends spokes, or plots."""
        self._send(lambda: self._live().add(batch.block))

    def look(self) -> None:
        """Sends the plots that have come."""
        if self._process is not None:
            self._send(self._process.ended)

    def close(self, reason: str) -> None:
        """Sends the plots that come soon."""
        with contextlib.suppress(OSError, EOFError):
            if self._process is not None:
                self._send(partial(self._process.ended, PATIENCE))
        self._end()

    def _live(self) -> LivePlots:
        """The plots of these spokes; after the process has failed those of another one."""
        assert self._radar is not None, "open_epoch comes first"
        if self._plots is None:
            known, note_lost, server = self._radar.epoch.info.radar, self._port.note_lost, self._server()
            begun: Callable[[], Extract] = partial(extraction, known, _tell)
            if server is not None:
                self._process = PlotProcess(server, known, _tell, note_lost)
                begun = self._process.begun
            self._plots = LivePlots(known.azimuths, begun, note_lost)
        return self._plots

    def _send(self, plots: Callable[[], list[Plot]]) -> None:
        try:
            ended = plots()
        except (OSError, EOFError):
            if self._process is None:  # none could be started
                raise
            self._end()
            raise ConnectionError(GONE) from None
        assert self._radar is not None
        self._port.send(plot_blocks(ended, self._radar.epoch, self._sac, self._sic))

    def _end(self) -> None:
        if self._process is not None:
            self._process.close()
        self._process = self._plots = None


def _tell(flood: str) -> None:
    log_event("too many plots", port="asterix-plots", reason=flood)
