"""Functions called in a process: results, errors, limits."""

import pytest

from radar_service.processes import call
from radar_service.processes.call import ProcessFault, Progress, call_in_process
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.limits import SET_UP_NICENESS, MachineBusyError
from radar_service.service.jobs import WatchedJob
from tests.descriptors import descriptors_left
from tests.processes import tasks


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
