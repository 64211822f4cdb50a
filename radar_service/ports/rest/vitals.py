"""How the serving process itself fares: the delay of its event loop, and whether its threads, disk and workers still work."""

import asyncio
import shutil
from collections import Counter, deque
from collections.abc import Iterable
from pathlib import Path

from radar_service.service.jobs import JobQueue
from radar_service.service.radio.radio_state import State
from radar_service.service.radio.station import Station

LAG_PERIOD = 0.25  # s between two looks at the event loop
LAG_SAMPLES = 60  # the worst of the last 15 s is given: a reader of metrics comes every 15 s
POOL_SECONDS = 1.0  # until the pool of threads counts as stuck; the image's health check waits for 2 s
JOB_SECONDS = 900.0  # until a job counts as stuck: a scene may take 240 s after others before it
MIN_FREE_BYTES = 128 * 2**20  # of the disk: two uploads


class Vitals:
    """Watches the serving process. Belongs to the event loop.

    jobs: its queue of jobs; folder: where it stores uploads.
    """

    def __init__(self, jobs: JobQueue, folder: Path) -> None:
        self._jobs, self._folder = jobs, folder
        self._lags: deque[float] = deque(maxlen=LAG_SAMPLES)
        self._timer: asyncio.TimerHandle | None = None
        self._probe: asyncio.Task[int] | None = None

    @property
    def lag(self) -> float:
        """The longest delay of the event loop lately [s]."""
        return max(self._lags, default=0.0)

    @property
    def tasks(self) -> int:
        """Number of tasks on the event loop; read there."""
        return len(asyncio.all_tasks())

    @property
    def job_states(self) -> Counter[str]:
        """Number of jobs in each state."""
        return Counter({"waiting": 0, "running": 0} | Counter(job.state for job in self._jobs.jobs))

    def start(self) -> None:
        """Starts to watch the event loop."""
        loop = asyncio.get_running_loop()
        self._timer = loop.call_at(loop.time() + LAG_PERIOD, self._note_lag, loop.time() + LAG_PERIOD)

    def close(self) -> None:
        """Stops watching."""
        if self._timer:
            self._timer.cancel()

    async def problems(self, stations: Iterable[Station]) -> list[str]:
        """Returns what keeps the service from working, a line each."""
        lines = []
        for state, station in ((each.transmitter.state, each) for each in stations):
            if not (state.fault or state.now is State.RESTARTING or station.transmitter.supervisor.worker.is_alive):
                lines.append(f"radar {station.identity}: its worker has died")
        if not await self._pool_works():
            lines.append(f"threads: none was free for {POOL_SECONDS:g} s")
        if any(job.state == "running" and job.as_dict()["seconds"] > JOB_SECONDS for job in self._jobs.jobs):
            lines.append(f"jobs: one has taken more than {JOB_SECONDS:g} s")
        if shutil.disk_usage(self._folder).free < MIN_FREE_BYTES:
            lines.append(f"disk: less than {MIN_FREE_BYTES / 2**20:.0f} MiB are free for uploads")
        return lines

    def _note_lag(self, due: float) -> None:
        self._lags.append(asyncio.get_running_loop().time() - due)
        self.start()

    async def _pool_works(self) -> bool:
        """Whether the default pool of threads does a task in time; one that does not keeps this one task."""
        if self._probe is None or self._probe.done():
            self._probe = asyncio.create_task(asyncio.to_thread(int))
        await asyncio.wait({self._probe}, timeout=POOL_SECONDS)
        return self._probe.done()
