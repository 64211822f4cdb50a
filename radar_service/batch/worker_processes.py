"""An executor of worker processes on this machine. A worker that dies fails its own job alone, and another takes its place.

Workers end with this process, however it ends: each holds a pipe of it, and ends where that is closed.
"""

import contextlib
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from queue import SimpleQueue
from typing import Any

from radar_service.batch.jobs import Executor
from radar_service.processes.channel import portable
from radar_service.processes.limits import limit_memory
from radar_service.processes.stop_signals import TERMINATED

ATTEMPTS = 3  # of a job whose workers die, as Dask has it by default: then the job itself is the likely cause
GRACE = 5.0  # s that a worker without work has to end

Call = tuple[Callable[..., Any], tuple[Any, ...]]
Waiting = tuple["Future[Any]", Call]


class WorkerDied(Exception):
    """The workers of a job died, again and again. The text says how the last one ended."""


@contextlib.contextmanager
def processes(count: int, memory: int | None = None) -> Iterator[Executor | None]:
    """So many processes as an executor; None for one, which is this process.

    memory: that each may take beyond what it begins with [bytes]; None for no limit. This process itself has none.
    """
    if count == 1 and memory is None:
        yield None
        return
    with WorkerProcesses(count, memory) as workers:
        yield workers


class WorkerProcesses:
    """Worker processes, each started with its first job. Leaving its `with` block ends them; jobs that they have are lost."""

    def __init__(self, count: int, memory: int | None = None) -> None:
        """count: of processes; memory: that each may take beyond what it begins with [bytes]; None: no limit."""
        self._memory = memory
        self._jobs: SimpleQueue[Waiting | None] = SimpleQueue()
        self._lock, self._closing = threading.Lock(), False
        self._workers: dict[int, _Worker] = {}
        self._threads = [
            threading.Thread(target=self._serve, args=(k,), name=f"worker {k}", daemon=True) for k in range(count)
        ]
        for thread in self._threads:
            thread.start()

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> "Future[Any]":
        """Begins function(*arguments) in a worker. Its future may have WorkerDied, or what it raised, with its traceback."""
        future: Future[Any] = Future()
        self._jobs.put((future, (function, arguments)))
        return future

    @property
    def pids(self) -> list[int]:
        """The process ids of the workers that have started."""
        return [worker.process.pid for worker in [*self._workers.values()] if worker.process.pid]

    def __enter__(self) -> "WorkerProcesses":
        return self

    def __exit__(self, *error: object) -> None:
        with self._lock:  # no worker starts from now on
            self._closing = True
        for _ in self._threads:
            self._jobs.put(None)
        for worker in [*self._workers.values()]:
            worker.end()
        for thread in self._threads:
            thread.join()

    def _serve(self, number: int) -> None:
        """Gives jobs to one worker after the other."""
        while (job := self._jobs.get()) is not None:
            future, call = job
            if self._closing:
                future.cancel()
            elif future.set_running_or_notify_cancel():
                try:
                    succeeded, result = self._reply(number, call)
                except BaseException as error:
                    succeeded, result = False, error
                if succeeded:
                    future.set_result(result)
                else:
                    future.set_exception(result)

    def _reply(self, number: int, call: Call) -> tuple[bool, Any]:
        """What a worker replies to a call. Raises WorkerDied where its workers die ATTEMPTS times."""
        ends = ""
        for _ in range(ATTEMPTS):
            worker = self._worker(number)
            try:
                return worker.reply(call)
            except (EOFError, OSError):
                if not worker.has_died:
                    raise
                ends = worker.how_ended
                del self._workers[number]
        raise WorkerDied(
            f"its worker process died {ATTEMPTS} times, the last one {ends}: look for too little memory, or a crash"
        )

    def _worker(self, number: int) -> "_Worker":
        """The worker of that number, which is started where there is none."""
        with self._lock:
            if self._closing:
                raise WorkerDied("the workers are ended")
            if number not in self._workers:
                self._workers[number] = _Worker(self._memory)
            return self._workers[number]


class _Worker:
    """One process, and the pipe to it."""

    def __init__(self, memory: int | None) -> None:
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self.process: SpawnProcess = context.Process(target=_work, args=(theirs, memory), daemon=False)
        self.process.start()
        theirs.close()  # so that its end closes the pipe
        self._lock = threading.Lock()  # of two threads that wait for a process, one hears that there is none
        self._busy = False

    def reply(self, call: Call) -> tuple[bool, Any]:
        """Whether a call in the process succeeds, and its result or its error. Raises EOFError or OSError where it dies."""
        self._busy = True
        self._pipe.send(call)
        reply: tuple[bool, Any] = self._pipe.recv()
        self._busy = False
        return reply

    @property
    def has_died(self) -> bool:
        """Whether the process has ended, or is about to."""
        with self._lock:
            self.process.join(GRACE)
            return self.process.exitcode is not None

    @property
    def how_ended(self) -> str:
        """How the process ended, in words."""
        code = self.process.exitcode or 0
        return f"by {signal.Signals(-code).name}" if code < 0 else f"with status {code}"

    def end(self) -> None:
        """Ends the process, at once where it has a job. Any thread may call it, more than once."""
        with self._lock:
            if self._busy:
                self.process.terminate()
            self._pipe.close()
            self.process.join(GRACE)
            if self.process.exitcode is None:
                self.process.kill()
                self.process.join()


def _work(pipe: Connection, memory: int | None) -> None:
    """What a worker does: calls that the pipe brings, until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all of a terminal; the first process ends the others
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(TERMINATED))  # a job ends what it has started
    threading.Thread(target=_end_with_parent, name="end with parent", daemon=True).start()
    if memory is not None:
        limit_memory(memory)
    while True:
        try:
            function, arguments = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            pipe.send((True, function(*arguments)))
        except Exception as error:
            error.add_note(f"in a worker process:\n{traceback.format_exc()}")
            pipe.send((False, portable(error)))


def _end_with_parent() -> None:
    """Ends this process when the one that started it ends, in the middle of a job too."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os.kill(os.getpid(), signal.SIGTERM)
        threading.main_thread().join(GRACE)
        os._exit(1)
