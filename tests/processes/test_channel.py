"""Messages between processes: what is sent arrives, and a missing end is noticed."""

import fcntl
import os
import socket
import sys
import termios
import threading

import numpy as np
import pytest

from radar_service.processes.channel import CAN_FORK, Channel, forked, portable
from tests.descriptors import descriptors_left, open_descriptors

SOON = 60.0  # s, for what should take milliseconds


@pytest.fixture
def ends() -> tuple[Channel, Channel]:
    here, there = (Channel(end) for end in socket.socketpair())
    yield here, there  # type: ignore[misc]
    here.close()
    there.close()


@pytest.mark.parametrize("left", [0, 1])
def test_ends_for_which_no_descriptors_are_left_are_an_error_and_stay_closed(
    left: int, ends: tuple[Channel, Channel]
) -> None:
    here, there = ends
    pair = socket.socketpair()
    here.send_ends(pair)
    before = open_descriptors()
    with descriptors_left(left), pytest.raises(OSError, match="no file descriptors are left"):
        there.receive_ends(2)
    assert open_descriptors() == before
    here.send_ends(pair)
    for channel in there.receive_ends(2):
        channel.close()
    for end in pair:
        end.close()


def test_objects_and_arrays_arrive_as_they_were(ends: tuple[Channel, Channel]) -> None:
    here, there = ends
    field = np.arange(3_000_000, dtype=np.complex64).reshape(3, -1)  # more than a socket holds
    sender = threading.Thread(target=here.send, args=({"field": field, "name": "x", "empty": np.zeros(0)},))
    sender.start()
    message = there.receive(SOON)
    sender.join(SOON)
    np.testing.assert_array_equal(message["field"], field)
    assert message["name"] == "x" and message["empty"].size == 0 and message["field"].flags.writeable


def test_a_part_of_an_array_arrives_alone(ends: tuple[Channel, Channel]) -> None:
    here, there = ends
    whole = np.arange(12.0).reshape(3, 4)
    for part in (whole[1:], whole[:, 1:], whole.T):
        here.send(part)
        np.testing.assert_array_equal(there.receive(SOON), part)


def test_waiting_ends_after_a_time_and_nothing_is_lost(ends: tuple[Channel, Channel]) -> None:
    here, there = ends
    with pytest.raises(TimeoutError):
        there.receive(0.0)
    here.send(1)
    assert there.receive(0.0) == 1


def test_an_end_that_is_gone_is_noticed_by_both(ends: tuple[Channel, Channel]) -> None:
    here, there = ends
    assert not here.other_end_is_gone()
    there.close()
    assert here.other_end_is_gone()
    for end in ends:
        with pytest.raises(EOFError):
            end.receive(SOON)
        with pytest.raises(OSError):
            end.send(1)


def test_closing_wakes_a_thread_that_waits() -> None:
    """The thread has read half of a head, so it waits for the rest."""
    near, far = socket.socketpair()
    channel, ended = Channel(far), threading.Event()

    def receive() -> None:
        with pytest.raises(EOFError):
            channel.receive()
        ended.set()

    near.send(b"half")
    threading.Thread(target=receive, daemon=True).start()
    while unread(far):
        pass
    channel.close()
    assert ended.wait(SOON)
    near.close()


def unread(end: socket.socket) -> int:
    """Bytes that have arrived and were not read."""
    return int.from_bytes(fcntl.ioctl(end, termios.FIONREAD, bytes(4)), sys.byteorder)


def test_sockets_are_handed_over_between_messages(ends: tuple[Channel, Channel]) -> None:
    here, there = ends
    near, far = socket.socketpair()
    here.send("before")
    here.send_ends([near])
    here.send("after")
    near.close()
    assert there.receive(SOON) == "before"
    (handed,) = there.receive_ends(1)
    assert there.receive(SOON) == "after"
    handed.send(7)
    other = Channel(far)
    assert other.receive(SOON) == 7
    handed.close()
    other.close()
    here.close()
    with pytest.raises(EOFError):
        there.receive_ends(1)


def test_a_forgotten_end_ends_no_connection() -> None:
    near, far = socket.socketpair()
    here, there, copy = Channel(near), Channel(far), Channel(near.dup())
    copy.forget()
    here.send(3)
    assert there.receive(SOON) == 3
    here.close()
    there.close()


@pytest.mark.skipif(not CAN_FORK, reason="this system does not fork processes with libraries that have threads")
def test_a_forked_process_has_the_other_ends_alone() -> None:
    process, (first, second) = forked(2)
    if not process:
        try:
            second.send(first.receive() + 1)
        finally:
            os._exit(0)
    first.send(41)
    assert second.receive(SOON) == 42
    os.waitpid(process, 0)
    with pytest.raises(EOFError):
        first.receive(SOON)
    first.close()
    second.close()
    with descriptors_left(3), pytest.raises(OSError, match="descriptors|files"):
        forked(2)


def test_an_error_crosses_as_it_is_or_as_its_text() -> None:
    noted = ValueError("not so")
    noted.add_note("where")
    same = portable(noted)
    assert type(same) is ValueError and same.args == noted.args and same.__notes__ == ["where"]
    (held := OSError("a")).__dict__["lock"] = threading.Lock()  # which cannot cross
    assert repr(portable(held)) == "RuntimeError('OSError: a')"
    assert repr(portable(noted, (KeyError,))) == "RuntimeError('ValueError: not so')"
