"""Processes that are started and ended, many of them, and what happens when any of them is killed."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from radar_service.processes.fork_server import ForkServer
from tests.descriptors import descriptors_left, open_descriptors
from tests.processes import tasks

ROOT = Path(__file__).parents[2]
SOON = 60.0  # s, for what should take milliseconds
CHILDREN = 200


def until(condition: Callable[[], bool]) -> None:
    """Looks each 5 ms until the condition holds, so that what is waited for has the processor. Raises AssertionError after
    SOON."""
    deadline = time.monotonic() + SOON
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def is_gone(process: int) -> bool:
    """Whether there is no such process, not even a zombie."""
    return not Path(f"/proc/{process}").exists()


def test_a_child_runs_a_function_with_its_arguments(fork_server: ForkServer) -> None:
    child = fork_server.child(tasks.echo, 1, {"a": np.arange(3)})
    process, arguments = child.control.receive(SOON)
    assert process == child.process != os.getpid() and arguments[0] == 1 and arguments[1]["a"].tolist() == [0, 1, 2]
    child.data.send("again")
    assert child.control.receive(SOON) == "again"
    child.close()
    until(lambda: is_gone(child.process))


@pytest.mark.parametrize("left", range(4))
def test_without_descriptors_no_child_starts_and_none_is_lost(left: int, fork_server: ForkServer) -> None:
    fork_server.child(tasks.wait).close()  # it runs
    before = open_descriptors()
    with descriptors_left(left), pytest.raises(OSError, match="Too many open files"):
        fork_server.child(tasks.wait)
    assert open_descriptors() == before


@pytest.mark.parametrize("left", [4, 5, 6, 7])
def test_without_descriptors_for_the_server_process_none_is_lost(left: int) -> None:
    server, before = ForkServer(), open_descriptors()
    with descriptors_left(left), pytest.raises(OSError):
        server.child(tasks.wait)
    assert open_descriptors() == before
    server.close()


def test_many_children_leave_nothing_behind(fork_server: ForkServer) -> None:
    fork_server.child(tasks.wait).close()
    before = len(os.listdir("/proc/self/fd"))
    children = []
    for _ in range(CHILDREN):
        children.append(fork_server.child(tasks.wait))
        children[-1].close()
        children[-1].close()  # which changes nothing
    until(lambda: all(is_gone(child.process) for child in children))
    assert len(os.listdir("/proc/self/fd")) <= before  # fewer where an earlier test's were still open


def test_a_child_that_crashes_is_noticed_and_no_other_suffers(fork_server: ForkServer) -> None:
    other = fork_server.child(tasks.echo)
    child = fork_server.child(tasks.crash)
    with pytest.raises(EOFError):
        child.control.receive(SOON)
    child.close()
    other.control.receive(SOON)
    other.data.send(5)
    assert other.control.receive(SOON) == 5
    other.close()


def test_a_server_that_is_killed_is_replaced_and_its_children_go_on() -> None:
    server = ForkServer()
    child = server.child(tasks.echo)
    process, _ = child.control.receive(SOON)
    os.kill(int(Path(f"/proc/{process}/stat").read_text().split()[3]), signal.SIGKILL)  # the parent
    second = server.child(tasks.echo)
    assert second.control.receive(SOON)[0] == second.process
    child.data.send("still here")
    assert child.control.receive(SOON) == "still here"
    for one in (child, second):
        one.close()
    server.close()


def test_a_server_that_was_closed_starts_no_more_children_and_nobody_waits_for_its_imports() -> None:
    """It never gets as far as to answer: its module waits for ever."""
    server, failed = ForkServer(("tests.processes.endless_import",)), threading.Event()

    def ask() -> None:
        with pytest.raises(OSError):
            server.child(tasks.wait)
        failed.set()

    asking = threading.Thread(target=ask)
    server.start()
    asking.start()
    server.close()
    assert failed.wait(SOON)
    asking.join(SOON)
    with pytest.raises(OSError):
        server.child(tasks.wait)


def test_children_end_when_the_service_is_killed() -> None:
    """The service is a process of its own here; it prints the numbers of its child and of the server."""
    code = """
import threading
from radar_service.processes.fork_server import ForkServer
from tests.processes import tasks
server = ForkServer()
child = server.child(tasks.echo)
print(child.control.receive()[0], flush=True)
threading.Event().wait()
"""
    service = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert service.stdout is not None
    child = int(service.stdout.readline())
    server = int(Path(f"/proc/{child}/stat").read_text().split()[3])
    service.kill()
    service.communicate()
    until(lambda: is_gone(child) and is_gone(server))
