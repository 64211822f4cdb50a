"""Spares of processes."""

import contextlib
import os
import signal
import threading
from collections.abc import Iterator

import pytest

from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import Child, ForkServer
from radar_service.service.radio.spare import RUN, NewSpare, Spares, SpareTakesOver
from tests.processes.test_fork_server import is_gone, until

SOON = 60.0  # s, for what should take milliseconds


def counting(control: Channel, data: Channel) -> None:
    """Counts what it is told, and so do its spares. It looks after its spare when it is told 0; not while it answers: -0.5."""
    count = control.receive()
    spares, answering = Spares(control, data), threading.Lock()
    while True:
        spares.first()
        with contextlib.suppress(SpareTakesOver):
            while True:
                count += (number := spares.ends[1].receive())
                if not number:
                    spares.renew(answering)
                if number == -0.5:
                    with answering:
                        spares.renew(answering)
                spares.ends[1].send((spares.is_spare, count))


@pytest.fixture
def child(fork_server: ForkServer) -> Iterator[Child]:
    child = fork_server.child(counting)
    child.control.send(5)
    yield child
    child.close()


def spare_of(child: Child) -> Child:
    return Child(child.control.receive(SOON), *child.control.receive_ends(2))


def told(child: Child, number: float) -> tuple[bool, float]:
    child.data.send(number)
    answer: tuple[bool, float] = child.data.receive(SOON)
    return answer


def test_a_spare_has_the_memory_of_the_moment_and_channels_of_its_own(child: Child) -> None:
    first = spare_of(child)
    assert told(child, 1) == (False, 6)
    child.close()
    until(lambda: is_gone(child.process))
    first.control.send(RUN)
    second = spare_of(first)
    assert told(first, 10) == (True, 15)
    second.control.send(RUN)
    third = spare_of(second)
    assert told(second, 100) == (True, 105)
    for one in (first, second, third):
        one.close()
    until(lambda: all(is_gone(one.process) for one in (first, second, third)))


def test_a_spare_ends_with_its_channel_or_when_it_is_told_anything_else(child: Child) -> None:
    first = spare_of(child)
    first.control.send("something else")
    with pytest.raises(EOFError):
        first.control.receive(SOON)
    assert told(child, 1) == (False, 6)
    first.close()


def test_the_service_sees_the_end_of_a_process_that_has_a_spare(child: Child) -> None:
    """The spare holds no ends of the process that forked it."""
    spare = spare_of(child)
    child.data.send("no number")  # which ends it by an error
    with pytest.raises(EOFError):
        child.data.receive(SOON)
    spare.close()


def test_a_spare_that_has_died_is_replaced(child: Child) -> None:
    first = spare_of(child)
    assert told(child, 0) == (False, 5)  # there is nothing to do
    os.kill(first.process, signal.SIGKILL)
    until(lambda: is_gone(first.process))
    assert told(child, 1.5) == (False, 6.5)
    assert told(child, -0.5) == (False, 6)  # answers at once, without a new spare
    child.data.send(0)
    new = child.data.receive(SOON)
    assert isinstance(new, NewSpare)
    second = Child(new.process, *child.data.receive_ends(2))
    assert child.data.receive(SOON) == (False, 6)
    child.close()
    second.control.send(RUN)
    third = spare_of(second)
    assert told(second, 10) == (True, 16)
    for one in (first, second, third):
        one.close()
    until(lambda: all(is_gone(one.process) for one in (second, third)))
