"""Still pictures of the last revolution: drawn in a process, one at a time, a few a second, and kept while they hold."""

import asyncio
import time
from collections.abc import Callable

from radar_service.display.video import Controls
from radar_service.processes.call import call_in_process
from radar_service.processes.fork_server import ForkServer
from radar_service.service.jobs import JobQueue, WatchedJob
from radar_service.service.radio.last_scan import Revolution, draw
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import cell_layout

MAX_PER_SECOND = 4  # drawn for all clients together; equal ones are drawn once
MAX_WAITING = 4
MAX_KEPT = 8  # pictures; one of 2048 pixels has some 2 MB

Key = tuple[object, ...]


class Pictures:
    """Draws pictures of radars. Belongs to the event loop. pause: waits so many seconds, in the thread that draws."""

    def __init__(self, server: ForkServer, pause: Callable[[float], None] = time.sleep) -> None:
        self._server, self._pause = server, pause
        self._queue = JobQueue(1, MAX_WAITING)
        self._kept: dict[Key, asyncio.Task[bytes]] = {}
        self._drawn = 0.0  # when the last one was begun

    async def png(self, station: Station, size: int, range_max: float | None) -> bytes:
        """Returns a picture of `size` pixels out to range_max [m]; a running radar gets one for each revolution.

        Raises Busy where too many are requested, and ProcessFault.
        """
        revolution, video = station.last_scan.read(), station.settings.video
        to = range_max or station.settings.range
        key = (station.identity, station.hub.epoch, moment(station, revolution), size, to, video)
        if key not in self._kept:
            title = "" if station.epoch.is_blind else revolution.of.scene.name
            work = self._work(revolution, video, size, to, title)
            self._kept[key] = asyncio.create_task(self._queue.run("picture", work))
            while len(self._kept) > MAX_KEPT:
                del self._kept[next(iter(self._kept))]
        try:
            return await asyncio.shield(self._kept[key])
        except BaseException:
            if key in self._kept and self._kept[key].done():
                del self._kept[key]
            raise

    def close(self) -> None:
        """Ends drawing."""
        self._queue.close()

    def _work(
        self, revolution: Revolution, video: Controls, size: int, to: float | None, title: str
    ) -> Callable[[WatchedJob], bytes]:
        of = revolution.of
        arguments = (
            revolution.rows, of.radar.azimuths, cell_layout(of, None, to), video, of.noise_power,
            title, size, to, revolution.heading,
        )  # fmt: skip

        def work(job: WatchedJob) -> bytes:
            self._pause(max(0.0, self._drawn + 1.0 / MAX_PER_SECOND - time.monotonic()))
            self._drawn = time.monotonic()
            return bytes(call_in_process(self._server, job, draw, *arguments))

        return work


def moment(station: Station, revolution: Revolution) -> tuple[str, int]:
    """Returns what a picture shows: these very spokes while the radar is paused, otherwise this revolution."""
    if station.settings.pace.state == "pause":
        return "spoke", revolution.next
    return "scan", revolution.next // revolution.of.radar.azimuths
