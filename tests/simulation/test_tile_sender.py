"""Tiles that are sent while their process computes on: how many wait, and what an order does."""

import socket
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from radar_service.processes.channel import CAN_FORK, Channel
from radar_service.simulation import tile_processes
from radar_service.simulation.engine_set_up import SourceTile
from radar_service.simulation.tile_processes import Computed, TileSender

pytestmark = pytest.mark.skipif(not CAN_FORK, reason="this system does not fork processes with libraries that have threads")

TIMEOUT = 60.0  # s after which a test that waits fails
CELLS = 2**17  # of a tile: 1 MiB of field, which no socket takes at once


@pytest.fixture
def ends() -> Iterator[tuple[TileSender, Channel]]:
    """A sender, and who reads."""
    near, far = (Channel(end) for end in socket.socketpair())
    yield TileSender(near), far
    near.close()
    far.close()


def tile(number: int) -> Computed:
    field = np.full((1, CELLS), number, dtype=np.complex64)
    return Computed(SourceTile(number, field, np.zeros((1, 0), dtype=np.float32), None, None), 0.0)


def received(reader: Channel) -> int:
    message = reader.receive(TIMEOUT)
    assert isinstance(message, Computed) and (message.tile.field == message.tile.start).all()
    return message.tile.start


def test_tiles_wait_in_order_while_nobody_reads(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    for number in range(4):
        sender.put(tile(number))
        assert not sender.has_order(10)
    sender.put("done")
    assert [received(reader) for _ in range(4)] == [0, 1, 2, 3] and reader.receive(TIMEOUT) == "done"


@pytest.mark.parametrize("most", [2, 100])
def test_no_more_are_computed_than_may_wait(
    ends: tuple[TileSender, Channel], most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One is being sent; of the others two are one too many, by their number or by their size."""
    monkeypatch.setattr(tile_processes, "BYTES_AHEAD", 8 * CELLS + 1 if most > 2 else 2**30)
    sender, reader = ends
    for number in range(3):
        sender.put(tile(number))
    went_on = threading.Event()

    def wait() -> None:
        assert not sender.has_order(most)
        went_on.set()

    waiting = threading.Thread(target=wait, daemon=True)
    waiting.start()
    assert not went_on.wait(0.1)
    assert received(reader) == 0
    assert went_on.wait(TIMEOUT)
    assert [received(reader), received(reader)] == [1, 2]


def test_soon_after_an_order_few_wait(ends: tuple[TileSender, Channel], monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of three that are not being sent are too many until STEERED_SECONDS have passed, while nobody reads."""
    sender, _ = ends
    monkeypatch.setattr(tile_processes, "STEERED_SECONDS", 0.3)
    begun = time.monotonic()
    sender.begin()
    for number in range(3):
        sender.put(tile(number))
    assert not sender.has_order(100)
    assert time.monotonic() >= begun + 0.3
    assert not sender.has_order(100)


def test_an_order_ends_the_wait_and_what_waits_is_dropped(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    for number in range(3):
        sender.put(tile(number))
    answers: list[bool] = []
    waiting = threading.Thread(target=lambda: answers.append(sender.has_order(1)), daemon=True)
    waiting.start()
    reader.send("stop")
    waiting.join(TIMEOUT)
    assert answers == [True]
    sender.drop()
    sender.put("done")
    messages = [reader.receive(TIMEOUT)]
    while messages[-1] != "done":
        messages.append(reader.receive(TIMEOUT))
    assert len(messages) <= 2


def test_the_end_of_the_reader_is_an_order(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    for number in range(3):
        sender.put(tile(number))
    reader.close()
    assert sender.has_order(1)


def test_what_cannot_be_sent_ends_the_connection(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    sender.put(ValueError(lambda: None))
    with pytest.raises(EOFError):
        reader.receive(TIMEOUT)
    assert sender.has_order(1)
