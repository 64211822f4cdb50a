"""The process that measures a plan beside the first spokes."""

import os
import signal
import socket

import pytest

from radar_service.processes.channel import CAN_FORK, Channel
from radar_service.processes.fork_server import ForkServer
from radar_service.service.radio.spare import PlanChild
from tests.processes.test_fork_server import is_gone, until
from tests.service.radio.recording import SOON

pytestmark = pytest.mark.skipif(not CAN_FORK, reason="this system has no spares either")


def measuring(control: Channel, data: Channel) -> None:
    """Has its own process measured; tells who did, and what comes after that."""
    child = PlanChild.forked(lambda: {"process": os.getpid()}, (control, data))
    assert child is not None
    until(lambda: (plan := child.measured()) is not None and control.send((os.getpid(), plan)) is None)
    control.send(child.measured())
    control.receive()


def left_waiting(control: Channel, data: Channel) -> None:
    """Tells which process measures, which it does for ever, and ends."""
    near, far = (Channel(end) for end in socket.socketpair())

    def wait() -> dict[str, object]:
        far.send(os.getpid())
        signal.pause()
        return {}

    child = PlanChild.forked(wait, (control, data))
    assert child is not None
    control.send((near.receive(), child.measured()))


def dying(control: Channel, data: Channel) -> None:
    """Has itself measured by a process that dies of it."""

    def die() -> dict[str, object]:
        os._exit(1)

    child = PlanChild.forked(die, (control, data))
    assert child is not None
    os.wait()
    assert child.measured() is None and child.measured() is None
    control.send("no plan")
    control.receive()


def test_the_plan_comes_once_from_another_process(fork_server: ForkServer) -> None:
    child = fork_server.child(measuring)
    process, plan = child.control.receive(SOON)
    assert process == child.process != plan["process"]
    assert child.control.receive(SOON) is None
    child.close()
    until(lambda: is_gone(plan["process"]))


def test_a_process_that_measures_holds_no_channel_open(fork_server: ForkServer) -> None:
    """The service learns at once that a scene's process is gone, though the one that measures lives."""
    child = fork_server.child(left_waiting)
    process, plan = child.control.receive(SOON)
    assert plan is None
    for end in (child.control, child.data):
        with pytest.raises(EOFError):
            end.receive(SOON)
    os.kill(process, signal.SIGKILL)
    until(lambda: is_gone(process))
    child.close()


def test_one_that_dies_leaves_no_plan(fork_server: ForkServer) -> None:
    child = fork_server.child(dying)
    assert child.control.receive(SOON) == "no plan"
    child.close()
