"""What a child process is like: deaf to signals of the terminal, and first to go where memory runs out."""

import os
import signal
from pathlib import Path

from radar_service.processes.fork_server import ForkServer
from tests.processes import tasks

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
