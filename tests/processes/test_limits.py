"""Limits of processes and the priority of set-up."""

import os
import platform
import resource
import sys
import threading

import pytest

from radar_service.processes import limits
from radar_service.processes.call import Progress, call_in_process
from radar_service.processes.fork_server import ForkServer
from tests.processes import tasks
from tests.service.held import resident_memory


class Session:
    """A file that refuses so many orders."""

    def __init__(self, errors: list[type[OSError]]) -> None:
        self.errors, self.written = errors, list[str]()

    def write_text(self, text: str) -> None:
        if self.errors:
            raise self.errors.pop()
        self.written.append(text)


def test_a_child_finds_modules_as_this_process_does_and_computes_with_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", ["/elsewhere", "here"])
    assert limits.child_environment() == {
        "PYTHONPATH": os.pathsep.join(["/elsewhere", os.path.abspath("here")]),
        "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1",
    }  # fmt: skip


@pytest.fixture
def only_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leaves the session of the tests as it is, on a machine that does nothing else."""
    monkeypatch.setattr(limits, "SESSION", Session([]))
    monkeypatch.setattr(limits, "busy_threads", lambda: 0.0)


class Statistics:
    """What the kernel tells from look to look of threads that run."""

    def __init__(self, *running: int) -> None:
        self.running = list(running)

    def read_text(self) -> str:
        if not self.running:
            raise FileNotFoundError
        return f"cpu  1 2 3\nprocs_running {self.running.pop()}\nprocs_blocked 0\n"


@pytest.mark.parametrize(
    ("running", "threads"), [([9] * 8, 4.0), ([1, 2, 3, 4, 3, 2, 1, 2], 0.0), ([5, 3, 9, 9, 9, 9, 9, 9], 1.0), ([], 0.0)],
    ids=["programs that compute", "a feed that waits in between", "both", "a system that does not tell"],
)  # fmt: skip
def test_threads_that_want_a_processor_all_the_time_are_counted(
    running: list[int], threads: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "STATISTICS", Statistics(*running))
    monkeypatch.setattr(limits, "LOOK_PAUSE", 0.0)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    assert limits.busy_threads() == threads


@pytest.mark.parametrize(("busy", "niceness"), [(0.0, 10), (0.3, 10), (1.0, 6), (2.0, 3), (4.0, 0), (50.0, 0)])
def test_set_up_gets_a_fifth_of_a_processor_beside_other_programs(
    busy: float, niceness: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The weight of a level of niceness is 1.25 times that of the next one (sched(7)); at niceness 0 all share alike."""
    monkeypatch.setattr(limits, "busy_threads", lambda: busy)
    assert limits.set_up_niceness() == niceness
    weight = 1.25**-niceness
    assert weight / (weight + busy) >= 0.2 or niceness == 0


def test_both_ways_to_lower_a_priority_follow_what_else_the_machine_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "SESSION", session := Session([]))
    monkeypatch.setattr(limits, "busy_threads", lambda: 2.0)
    monkeypatch.setattr(limits, "leave_processor_free", lambda: None)
    lowered: list[int] = []
    monkeypatch.setattr(os, "nice", lowered.append)
    limits.lower_priority()
    own = os.getpriority(os.PRIO_PROCESS, 0)
    thread = limits.at_low_priority(lambda: os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))
    assert (lowered, session.written, thread) == ([3], ["3", "3", "0"], max(own, 3))


def test_set_up_has_a_low_priority_and_what_follows_has_not(only_threads: None) -> None:
    before = os.getpriority(os.PRIO_PROCESS, 0)
    lowered = limits.at_low_priority(lambda: os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))
    assert lowered == max(before, limits.SET_UP_NICENESS)
    assert os.getpriority(os.PRIO_PROCESS, 0) == before


@pytest.mark.skipif(not limits.SESSION.exists(), reason="this system does not group processes by session")
def test_so_has_its_session(fork_server: ForkServer) -> None:
    assert call_in_process(fork_server, Progress(), tasks.set_up_session_niceness) == [limits.SET_UP_NICENESS, 0]


@pytest.mark.parametrize("error", [FileNotFoundError, PermissionError])
def test_a_system_without_sessions_is_no_error(error: type[OSError], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "SESSION", Session([error]))
    limits.set_session_niceness(5)


def test_a_busy_kernel_is_asked_again_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits.time, "sleep", lambda _: None)
    monkeypatch.setattr(limits, "SESSION", session := Session([BlockingIOError, BlockingIOError]))
    limits.set_session_niceness(5)
    assert session.written == ["5"]
    monkeypatch.setattr(limits, "SESSION", session := Session([BlockingIOError] * 1000))
    limits.set_session_niceness(5)
    assert not session.written


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc is told to return memory")
def test_free_memory_is_returned_to_the_system() -> None:
    """Of 64 MiB in pieces every other one is freed: the heap keeps all of them until it is told."""
    piece = 64 * 2**10  # bytes: below what the C library maps by itself
    pieces = [bytearray(piece) for _ in range(1024)]
    del pieces[::2]
    before = resident_memory(os.getpid())
    limits.return_free_memory()
    assert before - resident_memory(os.getpid()) > 0.8 * piece * 512
    del pieces


linux_only = pytest.mark.skipif(sys.platform != "linux", reason="only Linux has processors of threads")


@linux_only
@pytest.mark.parametrize(
    ("usable", "kept"), [({0, 1}, [{1}]), ({3, 2, 7}, [{3, 7}]), ({5}, [])], ids=["two", "some of many", "one"]
)
def test_set_up_leaves_the_first_processor_free(
    usable: set[int], kept: list[set[int]], only_threads: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen: list[set[int]] = []
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: usable)
    monkeypatch.setattr(os, "sched_setaffinity", lambda _, processors: chosen.append(processors))
    limits.at_low_priority(lambda: None)
    assert chosen == kept


@linux_only
def test_what_follows_set_up_may_use_all_processors(fork_server: ForkServer, only_threads: None) -> None:
    usable = os.sched_getaffinity(0)
    left = usable - {min(usable)} or usable
    assert limits.at_low_priority(lambda: os.sched_getaffinity(0)) == left
    assert os.sched_getaffinity(0) == usable
    assert call_in_process(fork_server, Progress(), os.sched_getaffinity, 0) == left


@linux_only
def test_a_container_may_forbid_it(only_threads: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    monkeypatch.setattr(os, "sched_setaffinity", refused)
    assert limits.at_low_priority(lambda: 7) == 7


def test_an_error_of_set_up_is_raised(only_threads: None) -> None:
    with pytest.raises(ZeroDivisionError):
        limits.at_low_priority(lambda: 1 // 0)


def test_a_world_may_have_half_of_the_machine_and_always_something() -> None:
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    assert limits.default_memory() == max(limits.MIN_MEMORY, machine // 2)


def test_the_limit_counts_from_now() -> None:
    before = resource.getrlimit(resource.RLIMIT_CPU)
    try:
        limits.limit_processor_time(5.0)
        soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
        assert hard == before[1] and 4.5 <= soft - limits.used_processor_time() <= 6.1
    finally:
        resource.setrlimit(resource.RLIMIT_CPU, before)
