"""Worker processes: what they return, what happens when they die, and that they end with the process that has them."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from radar_service.batch.worker_processes import ATTEMPTS, WorkerDied, WorkerProcesses, processes

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def workers() -> Iterator[WorkerProcesses]:
    with WorkerProcesses(1) as some:
        yield some


def noted(folder: Path, number: int) -> int:
    """Notes a call in a folder; returns how often there was one of that number."""
    path = folder / str(number)
    path.write_text(path.read_text() + "x" if path.exists() else "x")
    return len(path.read_text())


def dies(folder: Path, number: int, times: int) -> int:
    """Kills its process, so many times."""
    if (count := noted(folder, number)) <= times:
        os.kill(os.getpid(), signal.SIGKILL)
    return count


def refuses(error: Exception) -> None:
    raise error


class Strange(Exception):
    """An error that no pipe takes."""

    def __init__(self) -> None:
        super().__init__("strange")
        self.held = lambda: None


def strange() -> None:
    raise Strange


def test_one_process_is_this_one_unless_its_memory_is_limited() -> None:
    with processes(1) as executor:
        assert executor is None
    with processes(1, 2**31) as executor:
        assert isinstance(executor, WorkerProcesses) and not executor.pids  # none starts before its first job


def test_a_worker_goes_from_job_to_job(workers: WorkerProcesses) -> None:
    futures = [workers.submit(os.getpid) for _ in range(3)]
    assert [future.result() for future in futures] == workers.pids * 3 and workers.pids != [os.getpid()]


def test_an_error_comes_back_with_its_traceback(workers: WorkerProcesses) -> None:
    """Also one of the kind that a broken pipe raises: the worker lives on."""
    for error in (ValueError("7 is too many"), OSError(28, "No space left on device"), EOFError("end")):
        future = workers.submit(refuses, error)
        raised = future.exception()
        assert type(raised) is type(error) and str(raised) == str(error) and "in refuses" in raised.__notes__[0]
    assert workers.submit(strange).exception().__class__ is RuntimeError


def test_a_worker_that_dies_is_replaced_and_its_job_tried_again(workers: WorkerProcesses, tmp_path: Path) -> None:
    before = workers.pids
    assert workers.submit(dies, tmp_path, 1, ATTEMPTS - 1).result() == ATTEMPTS and workers.pids != before


def test_a_job_whose_workers_die_again_and_again_fails_alone(workers: WorkerProcesses, tmp_path: Path) -> None:
    bad, good = workers.submit(dies, tmp_path, 1, 99), workers.submit(noted, tmp_path, 2)
    with pytest.raises(WorkerDied, match=rf"died {ATTEMPTS} times, the last one by SIGKILL: look for too little memory"):
        bad.result()
    assert good.result() == 1 and (tmp_path / "1").read_text() == "x" * ATTEMPTS


@pytest.mark.skipif(sys.platform != "linux", reason="other systems keep no limit of memory")
def test_memory_beyond_the_limit_is_an_error_of_the_job_alone() -> None:
    with processes(1, 2**28) as executor:
        assert executor is not None
        assert isinstance(executor.submit(bytearray, 2**29).exception(), MemoryError)
        assert len(executor.submit(bytearray, 2**10).result()) == 2**10


def test_leaving_ends_workers_in_the_middle_of_a_job(tmp_path: Path) -> None:
    """What waits is cancelled, and nobody waits for what runs."""
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    futures: list[Future[Any]] = []
    with WorkerProcesses(1) as workers:
        futures += [workers.submit(_wait_for_ever, fifo), workers.submit(os.getpid)]
        fifo.read_text()  # until the job has begun
        (pid,) = workers.pids
    assert isinstance(futures[0].exception(), WorkerDied) and futures[1].cancelled() and (tmp_path / "tidied").exists()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_leaving_while_a_worker_is_found_dead(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its end is collected once: who comes second is not told that the process lives on."""
    collected_by_another = threading.Event()

    def waitpid(pid: int, flag: int, real: Callable[[int, int], tuple[int, int]] = os.waitpid) -> tuple[int, int]:
        try:
            result = real(pid, flag)
        except ChildProcessError:
            collected_by_another.set()
            raise
        if result[0]:
            collected_by_another.wait(0.5)  # s that a second thread has to come before the first has noted the end
        return result

    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    with WorkerProcesses(1) as workers:
        future = workers.submit(_wait_for_ever, fifo)
        fifo.read_text()
        monkeypatch.setattr(os, "waitpid", waitpid)
    assert isinstance(future.exception(), WorkerDied) and not collected_by_another.is_set()


def _wait_for_ever(fifo: Path) -> None:
    try:
        fifo.write_text("begun")  # whoever reads it may end this process at once
        signal.pause()
    finally:
        fifo.with_name("tidied").touch()


KILLED = """
import os, signal, sys
from pathlib import Path
from radar_service.batch.worker_processes import WorkerProcesses
from tests.batch.test_worker_processes import _wait_for_ever

if __name__ == "__main__":
    workers = WorkerProcesses(1)
    workers.submit(_wait_for_ever, Path(sys.argv[1]))
    Path(sys.argv[1]).read_text()
    print(*workers.pids, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_workers_end_when_their_process_is_killed(tmp_path: Path) -> None:
    """Each holds the other end of our pipe: it closes when the last of them has ended."""
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "killed.py").write_text(KILLED)
    command = [sys.executable, str(tmp_path / "killed.py"), str(tmp_path / "fifo")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    run = subprocess.run(command, stdout=subprocess.PIPE, env=environment, timeout=60, text=True)  # reads to the end of all
    assert run.returncode == -signal.SIGKILL and (tmp_path / "tidied").exists()
    with contextlib.suppress(ProcessLookupError):
        os.kill(int(run.stdout), 0)
        assert Path(f"/proc/{int(run.stdout)}/stat").read_text().split()[2] == "Z"  # nobody is there to collect it
