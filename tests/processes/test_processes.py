"""The short modules of processes, each under its name."""

import os
import signal
from pathlib import Path

import pytest

from radar_service.processes import call
from radar_service.processes.call import ProcessFault, Progress, call_in_process
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.limits import SET_UP_NICENESS, MachineBusyError
from radar_service.processes.stop_signals import STOP_SIGNALS, ended_by_signals
from radar_service.service.jobs import WatchedJob
from tests.descriptors import descriptors_left
from tests.processes import tasks

# fork_server_main: what a child process is like: deaf to signals of the terminal, and first to go where memory runs out.
SOON = 60.0  # s, for what should take milliseconds


def test_a_child_ignores_what_ends_the_service(fork_server: ForkServer) -> None:
    child = fork_server.child(tasks.echo)
    child.control.receive(SOON)
    for ending in (signal.SIGINT, signal.SIGTERM):
        os.kill(child.process, ending)
    child.data.send("here")
    assert child.control.receive(SOON) == "here"
    assert Path(f"/proc/{child.process}/oom_score_adj").read_text().strip() == "500"
    child.close()


def test_a_function_that_does_not_exist_ends_the_child(fork_server: ForkServer, tmp_path: Path) -> None:
    child = fork_server.child(os.mkdir, str(tmp_path / "made"))  # takes other arguments than channels
    assert child.control.wait(SOON) and child.control.other_end_is_gone()
    child.close()
    assert not (tmp_path / "made").exists()


# stop_signals: the first signal ends the block, later ones change nothing, and afterwards the handlers are those of before.
@pytest.mark.parametrize("number", STOP_SIGNALS)
def test_a_signal_ends_the_block_once(number: int) -> None:
    before, tidied = [signal.getsignal(each) for each in STOP_SIGNALS], False
    with pytest.raises(SystemExit) as end, ended_by_signals():
        try:
            os.kill(os.getpid(), number)
            signal.pause()
        finally:
            for again in STOP_SIGNALS:
                os.kill(os.getpid(), again)
            tidied = True
    assert end.value.code == 0 and tidied
    assert [signal.getsignal(each) for each in STOP_SIGNALS] == before


# call: functions called in a process: results, errors, limits.
def test_results_and_errors_come_back(fork_server: ForkServer) -> None:
    assert call_in_process(fork_server, Progress(), tasks.twice, 21) == 42
    with pytest.raises(ValueError, match="not so"):
        call_in_process(fork_server, Progress(), tasks.refuse, "not so")


def test_it_does_not_compete_with_the_feed(fork_server: ForkServer) -> None:
    own, session = call_in_process(fork_server, Progress(), tasks.niceness)
    assert own >= session
    assert 0 <= session <= SET_UP_NICENESS  # as low as what else the machine does allows: see test_limits


@pytest.mark.parametrize("function", [tasks.crash, tasks.fill])
def test_a_crash_and_too_much_memory_are_faults(fork_server: ForkServer, function: object) -> None:
    with pytest.raises(ProcessFault, match="crashed"):
        call_in_process(fork_server, Progress(), function, 4 * call.MEMORY)  # type: ignore[arg-type]


def test_too_much_processor_time_is_a_fault(fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(call, "MAX_PROCESSOR_TIME", 0.1)  # the system counts whole seconds
    with pytest.raises(ProcessFault, match="more than 0.1 s of processor time"):
        call_in_process(fork_server, Progress(), tasks.compute_for_ever)


def test_a_machine_that_gives_no_processor_time_is_no_fault(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(call, "BACKSTOP", 0.2)
    with pytest.raises(MachineBusyError, match="the machine is busy: .* in 0.2 s; try again later"):
        call_in_process(fork_server, Progress(), tasks.wait)


def test_without_descriptors_it_is_to_be_tried_again(fork_server: ForkServer) -> None:
    assert call_in_process(fork_server, Progress(), tasks.twice, 21) == 42  # it runs
    with descriptors_left(2), pytest.raises(MachineBusyError, match="no process could be started .* try again later"):
        call_in_process(fork_server, Progress(), tasks.twice, 21)


def test_cancelling_ends_it(fork_server: ForkServer) -> None:
    class Cancelling(WatchedJob):
        def ends_with(self, close: object) -> None:
            super().ends_with(close)  # type: ignore[arg-type]
            self.cancel()

    with pytest.raises((ProcessFault, OSError)):
        call_in_process(fork_server, Cancelling("a", "test"), tasks.wait)
