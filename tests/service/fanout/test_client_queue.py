"""The queue of one client: what it keeps, what it loses, what it announces."""

import asyncio

import pytest

from radar_service import wire
from radar_service.service.codecs.codec import CODECS
from radar_service.service.fanout.client_queue import QUEUE_NOTICES, ClientQueue, QueueItem, gap
from radar_service.service.feed_request import View
from tests.service.fanout.batches import U8, batch, everything, numbered, opened


def test_a_gap_is_exactly_these_bytes() -> None:
    expected = bytes.fromhex(
        "85a474797065a3676170a565706f6368a165a566697273740aa5636f756e7405a6726561736f6ea178"
    )  # {type: gap, epoch: e, first: 10, count: 5, reason: x} by the msgpack specification
    assert gap(CODECS["native"], "e", 10, 5, "x").data == expected


async def test_the_bound_in_bytes_holds_but_lets_one_batch_through() -> None:
    hub, client = opened(), ClientQueue(U8, size=10)
    hub.join(client)
    for first in (0, 4, 8):
        await hub.publish(batch(first))
    assert numbered(await everything(client)) == [("gap", 0, 8), ("spokes", 8, 4)]


async def test_gaps_of_two_epochs_stay_apart_and_on_their_side_of_the_hello() -> None:
    hub, client = opened(), ClientQueue(U8, messages=1)
    hub.join(client)
    await hub.publish(batch(0))
    await hub.publish(batch(4))
    hub.open_epoch("f", lambda view, mode: wire.pack({"type": "hello", "epoch": "f"}))
    await hub.publish(batch(0, epoch="f"))
    await hub.publish(batch(4, epoch="f"))
    got = await everything(client)
    assert [(m["type"], m["epoch"]) for m in got] == [
        ("hello", "e"), ("gap", "e"), ("hello", "f"), ("gap", "f"), ("spokes", "f"),
    ]  # fmt: skip
    assert numbered(got) == [("gap", 0, 8), ("gap", 0, 4), ("spokes", 4, 4)]


async def test_a_client_that_never_reads_is_disconnected_before_notices_fill_the_memory() -> None:
    hub, client = opened(), ClientQueue(U8)
    hub.join(client)
    for k in range(QUEUE_NOTICES + 1):
        hub.open_epoch(str(k), lambda view, mode: wire.pack({"type": "hello", "epoch": "k"}))
    kinds = [m["type"] for m in await everything(client)]
    assert client.closed and kinds == [*["hello"] * (QUEUE_NOTICES + 2), "bye"]
    await client.ended()


async def test_a_client_with_losses_keeps_only_the_newest_batches_until_it_has_caught_up() -> None:
    """Batches of 32 KiB: 64 of them fit; after a loss two do, which are 64 KiB."""
    client, large = ClientQueue(View("u8")), bytes(32 * 1024)
    for k in range(64):
        client.put(QueueItem(large, "e", k, 1, True))
    assert client.lost == 0
    client.put(QueueItem(large, "e", 64, 1, True))
    assert [(item.first, item.count) for item in client.waiting] == [(0, 63), (63, 1), (64, 1)]
    assert client.lost == 63 and client.gaps == 1
    await client.get()
    client.put(QueueItem(large, "e", 65, 1, True))
    assert client.lost == 64  # it reads, but is still behind
    while client.waiting:
        await client.get()
    for k in range(66, 66 + 64):
        client.put(QueueItem(large, "e", k, 1, True))
    assert client.lost == 64 and len(client.waiting) == 64


async def test_a_message_goes_straight_to_a_waiting_client_and_else_keeps_its_order() -> None:
    client, written, room = ClientQueue(View("u8")), list[bytes](), True

    def write(frame: bytes) -> bool:
        written.extend([frame] if room else [])
        return room

    client.write = write
    items = [QueueItem(bytes([k]), "e", k, 1, True) for k in range(7)]
    client.put(items[0])  # nobody waits yet
    assert await client.get() == items[0] and not written
    waiting = asyncio.ensure_future(client.get())
    await asyncio.sleep(0)
    client.put(items[1])
    client.put(items[2])
    assert written == [item.frame for item in items[1:3]] and not waiting.done()
    room = False
    client.put(items[3])  # wakes who waits
    room = True
    client.put(items[4])  # not ahead of that one
    assert await waiting == items[3] and await client.get() == items[4]
    client.put(items[5])  # who waited has gone
    assert await client.get() == items[5] and len(written) == 2
    assert (client.delivered, client.bytes, client.lost) == (6, 6, 0)
    client.end(b"bye")
    client.put(items[6])
    assert (await client.get() or items[6]).data == b"bye" and await client.get() is None and len(written) == 2


async def test_a_message_that_the_protocol_does_not_have_counts_and_is_not_written() -> None:
    client, written = ClientQueue(View("u8")), list[bytes]()
    client.write = lambda frame: bool(written.append(frame)) or True
    waiting = asyncio.ensure_future(client.get())
    await asyncio.sleep(0)
    client.put(QueueItem(b"", "e", 0, 5))
    assert (await waiting) == QueueItem(b"", "e", 0, 5) and not written and client.started


@pytest.mark.parametrize(
    ("size", "head"),
    [(0, "8200"), (125, "827d"), (126, "827e007e"), (256, "827e0100"), (65_535, "827effff"), (65_536, "827f0000000000010000")],
)  # fmt: skip
def test_frames_are_those_of_the_standard(size: int, head: str) -> None:
    """256 and 65,536 bytes are the examples of RFC 6455, section 5.7."""
    data = bytes(range(256)) * 256
    assert QueueItem(data[:size], "e").frame == bytes.fromhex(head) + data[:size]
