"""Still pictures of the last revolution: drawn in a process, one at a time, a few a second, and kept while they hold."""

import asyncio
import time
from collections import deque
from collections.abc import Callable

from radar_service.display.video import Controls
from radar_service.stream.jobs import Busy, Job, JobQueue
from radar_service.stream.processes.call import call_in_process
from radar_service.stream.processes.fork_server import ForkServer
from radar_service.stream.radio.last_scan import Revolution, draw
from radar_service.stream.radio.station import Station
from radar_service.stream.source import cell_layout

MAX_PER_SECOND = 4  # drawn for all clients together; equal ones are drawn once
MAX_WAITING = 4
MAX_KEPT = 8  # pictures; one of 2048 pixels has some 2 MB

Key = tuple[object, ...]


class Pictures:
    """Draws pictures of radars. Belongs to the event loop."""

    def __init__(self, server: ForkServer, clock: Callable[[], float] = time.monotonic) -> None:
        self._server, self._clock = server, clock
        self._queue = JobQueue(1, MAX_WAITING)
        self._kept: dict[Key, asyncio.Task[bytes]] = {}
        self._drawn: deque[float] = deque(maxlen=MAX_PER_SECOND)

    async def png(self, station: Station, size: int, range_max: float | None) -> bytes:
        """Returns a picture of `size` pixels out to range_max [m]; a running radar gets one for each revolution.

        Raises Busy where too many are requested, and ProcessFault.
        """
        revolution, video = station.last_scan.read(), station.settings.video
        to = range_max or station.settings.range
        key = (station.identity, station.hub.epoch, moment(station, revolution), size, to, video)
        if key not in self._kept:
            self._keep(key, revolution, video, size, to)
        try:
            return await asyncio.shield(self._kept[key])
        except BaseException:
            if key in self._kept and self._kept[key].done():
                del self._kept[key]
            raise

    def close(self) -> None:
        """Ends drawing."""
        self._queue.close()

    def _keep(self, key: Key, revolution: Revolution, video: Controls, size: int, to: float | None) -> None:
        now = self._clock()
        if len(self._drawn) == MAX_PER_SECOND and now - self._drawn[0] < 1.0:
            raise Busy(f"{MAX_PER_SECOND} pictures a second are drawn; try again later")
        self._drawn.append(now)
        self._kept[key] = asyncio.create_task(self._queue.run("picture", self._work(revolution, video, size, to)))
        while len(self._kept) > MAX_KEPT:
            del self._kept[next(iter(self._kept))]

    def _work(self, revolution: Revolution, video: Controls, size: int, to: float | None) -> Callable[[Job], bytes]:
        engine = revolution.engine
        arguments = (
            revolution.rows, engine.scene.radar.azimuths, cell_layout(engine, None, to), video, engine.noise_power,
            engine.scene.name, size, to, revolution.heading,
        )  # fmt: skip
        return lambda job: bytes(call_in_process(self._server, job, draw, *arguments))


def moment(station: Station, revolution: Revolution) -> tuple[str, int]:
    """Returns what a picture shows: these very spokes while the radar is paused, otherwise this revolution."""
    if station.settings.pace.state == "pause":
        return "spoke", revolution.next
    return "scan", revolution.next // revolution.engine.scene.radar.azimuths
