"""Work that takes long, a bounded number at a time: preparing scenes, reading big bodies, drawing pictures.

Each job waits for a process that does the work. Jobs have threads of their own, so that nothing else waits for them, and no
job waits for another one.
"""

import asyncio
import secrets
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import RLock
from time import monotonic
from typing import Any, Literal, TypeVar

from radar_service.processes.call import Progress

Result = TypeVar("Result")
State = Literal["waiting", "running", "done", "failed", "cancelled"]

WORKERS = 2  # jobs at a time
MAX_WAITING = 8  # jobs that wait for a worker
MAX_FINISHED = 32  # jobs that are listed after their end
RETRY_SECONDS = 5  # until a refused client should try again: a small scene takes less


class Busy(Exception):
    """There are too many jobs. The text says what to do."""


class Cancelled(Exception):
    """The job was cancelled."""


class DuplicateJob(Exception):
    """Another job has that name."""


class WatchedJob(Progress):
    """One piece of work, and its progress for the function that does it. Belongs to the event loop, but for that.

    It runs until `JobQueue.run` has what it made: until then what ends it early closes that, afterwards it is the caller's.
    `_ending` guards the state.

    name: part of its address; kind: what it is for.
    """

    in_background = True

    def __init__(self, name: str, kind: str) -> None:
        super().__init__()
        self.name, self.kind = name, kind
        self.state: State = "waiting"
        self.doing = "waiting for a worker"
        self._began, self._ended = monotonic(), 0.0
        self._ending = RLock()
        self.result: asyncio.Future[Any] | None = None  # what `JobQueue.run` waits for

    @property
    def is_over(self) -> bool:
        """Whether it has ended, well or not."""
        return self.state in ("done", "failed", "cancelled")

    def cancel(self) -> None:
        """Ends the work now, or as soon as its process has started; who waits for the job is told at once."""
        if self._over("cancelled"):
            if self.result:
                self.result.cancel()
            self.close()

    def perform(self, work: Callable[["WatchedJob"], Result]) -> Result:
        """Runs the work in this thread. Raises the errors of the work, and Cancelled."""
        with self._ending:
            if self.state == "cancelled":
                raise Cancelled
            self.state = "running"
        try:
            return work(self)
        except Exception:
            self._over("failed")
            raise

    def succeed(self) -> None:
        """Ends the job well: what it made is the caller's. Raises Cancelled where it was cancelled before."""
        if not self._over("done"):
            raise Cancelled

    def as_dict(self) -> dict[str, Any]:
        """Returns the job as plain data."""
        seconds = (self._ended or monotonic()) - self._began
        return {"id": self.name, "kind": self.kind, "state": self.state, "doing": self.doing, "seconds": seconds}

    def _over(self, state: State) -> bool:
        """Ends the job in that state; returns whether it had not ended before."""
        with self._ending:
            if self.is_over:
                return False
            self.state, self._ended, self.doing = state, monotonic(), ""
        if state != "cancelled":
            self.finish()  # it holds what the job has made, and the job stays listed
        return True


class JobQueue:
    """Runs jobs, at most `workers` at a time while at most `waiting` others wait. Belongs to the event loop."""

    def __init__(self, workers: int = WORKERS, waiting: int = MAX_WAITING) -> None:
        self._maximum = workers + waiting
        self._threads = ThreadPoolExecutor(workers, thread_name_prefix="job")
        self._jobs: dict[str, WatchedJob] = {}
        self._closed = False

    @property
    def jobs(self) -> list[WatchedJob]:
        """Jobs that wait or run, and the last ones that have ended."""
        return list(self._jobs.values())

    def job(self, name: str) -> WatchedJob:
        """Returns the job of that name. Raises KeyError."""
        return self._jobs[name]

    async def run(self, kind: str, work: Callable[[WatchedJob], Result], name: str | None = None) -> Result:
        """Returns work(job), computed in a thread of the queue; `work` must end when the job is cancelled.

        name: of the job, by default a random one. Raises Busy, DuplicateJob, what the work raises, and Cancelled, at once: the
        thread is free when the work has ended.
        """
        job = self._add(kind, name or secrets.token_hex(4))
        job.result = asyncio.get_running_loop().run_in_executor(self._threads, job.perform, work)
        try:
            result: Result = await job.result
            job.succeed()
        except (Exception, asyncio.CancelledError):
            if job.state == "cancelled":
                raise Cancelled(f"{job.kind}: the job was cancelled") from None
            raise
        finally:
            self._finish(job)
        return result

    def close(self) -> None:
        """Cancels all jobs, and takes no more."""
        self._closed = True
        for job in self.jobs:
            job.cancel()
        self._threads.shutdown(wait=False)

    def _add(self, kind: str, name: str) -> WatchedJob:
        running = [job for job in self._jobs.values() if not job.is_over]
        if name in {job.name for job in running}:
            raise DuplicateJob(f'job: "{name}" runs already; give another name')
        if self._closed or len(running) >= self._maximum:
            raise Busy(f"{len(running)} jobs run or wait; try again later")
        self._jobs.pop(name, None)
        job = self._jobs[name] = WatchedJob(name, kind)
        return job

    def _finish(self, job: WatchedJob) -> None:
        """Forgets what the job has made, and the oldest jobs that have ended, beyond MAX_FINISHED."""
        job.result = None
        if not job.is_over:  # the request was cancelled, its work was not
            job.cancel()
        over = [name for name, other in self._jobs.items() if other.is_over]
        for name in over[: max(0, len(over) - MAX_FINISHED)]:
            del self._jobs[name]
