"""The short modules of processes, each under its name."""

import os
import signal
from pathlib import Path

import pytest

from radar_service.processes.fork_server import ForkServer
from radar_service.processes.stop_signals import STOP_SIGNALS, ended_by_signals
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
