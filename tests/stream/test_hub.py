"""The hub's promises, without a socket: nothing lost unannounced, nothing twice, nobody waits for a slow live client."""

import asyncio
from collections.abc import Coroutine
from typing import Any

import pytest

from radar_service.stream import hub as hub_module
from radar_service.stream import wire
from radar_service.stream.hub import MAX_VIEWS, Batch, Hub, Refused
from radar_service.stream.mailbox import MAILBOX_NOTICES, TOO_SLOW, Client, Item, View, gap

U8 = View("u8")


def run(test: Coroutine[Any, Any, None]) -> None:
    asyncio.run(asyncio.wait_for(test, 10))


def spokes(first: int, count: int, epoch: str = "e", size: int = 1) -> bytes:
    row = list(range(first, first + count))
    return wire.pack(
        {"type": "spokes", "epoch": epoch, "first": first, "count": count, "index": first, "time": row, "azimuth": row,
         "heading": row, "position": [[n, n] for n in row], "course": row, "speed": row,
         "data": bytes(n % 256 for n in row for _ in range(size))}
    )  # fmt: skip


def batch(first: int, count: int = 4, epoch: str = "e", views: tuple[View, ...] = (U8,), **more: Any) -> Batch:
    return Batch(epoch, first, count, {view: spokes(first, count, epoch) for view in views}, **more)


def opened(**options: Any) -> Hub:
    hub = Hub(lambda: 0.0, **options)
    hub.open_epoch("e", lambda view, mode: wire.pack({"type": "hello", "epoch": "e", "view": view.encoding}))
    return hub


async def everything(client: Client) -> list[dict[str, Any]]:
    """What lies in the mailbox."""
    found = []
    while client._queue or client._backlog:
        item = await client.get()
        assert item is not None
        found.append(wire.unpack(item.data))
    return found


def told(messages: list[dict[str, Any]]) -> list[tuple[str, int, int]]:
    """Type, first and count of the messages that carry numbers."""
    return [(m["type"], m["first"], m["count"]) for m in messages if "first" in m]


def test_a_gap_is_exactly_these_bytes() -> None:
    expected = bytes.fromhex(
        "85a474797065a3676170a565706f6368a165a566697273740aa5636f756e7405a6726561736f6ea178"
    )  # {type: gap, epoch: e, first: 10, count: 5, reason: x} by the msgpack specification
    assert gap("e", 10, 5, "x").data == expected


def test_hello_comes_first_and_then_spokes_in_order() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8)
        hub.join(client)
        await hub.publish(batch(0))
        await hub.publish(batch(4, 2))
        got = await everything(client)
        assert got[0] == {"type": "hello", "epoch": "e", "view": "u8"}
        assert told(got) == [("spokes", 0, 4), ("spokes", 4, 2)]

    run(test())


def test_a_slow_client_loses_the_oldest_batches_and_is_told_which() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8, messages=3)
        hub.join(client)
        for first in range(0, 40, 4):
            await hub.publish(batch(first))
        got = await everything(client)
        assert told(got) == [("gap", 0, 28), ("spokes", 28, 4), ("spokes", 32, 4), ("spokes", 36, 4)]
        assert got[1]["reason"] == "this client is too slow" and client.lost == 28

    run(test())


def test_the_bound_in_bytes_holds_but_lets_one_batch_through() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8, size=10)
        hub.join(client)
        for first in (0, 4, 8):
            await hub.publish(batch(first))
        assert told(await everything(client)) == [("gap", 0, 8), ("spokes", 8, 4)]

    run(test())


def test_gaps_of_two_epochs_stay_apart_and_on_their_side_of_the_hello() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8, messages=1)
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
        assert told(got) == [("gap", 0, 8), ("gap", 0, 4), ("spokes", 4, 4)]

    run(test())


def test_a_slow_client_does_not_hold_up_a_fast_one() -> None:
    async def test() -> None:
        hub, slow, fast = opened(), Client(U8, messages=1), Client(U8, messages=1)
        hub.join(slow)
        hub.join(fast)
        got = []
        for first in range(0, 40, 4):
            await hub.publish(batch(first))
            got += told(await everything(fast))
        assert got == [("spokes", first, 4) for first in range(0, 40, 4)]
        assert (fast.lost, slow.lost) == (0, 36)

    run(test())


def test_a_lossless_client_makes_the_producer_wait() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8, "lossless", messages=2)
        hub.join(client)
        producing = asyncio.ensure_future(produce(hub, range(0, 40, 4)))
        got: list[tuple[str, int, int]] = []
        await client.get()  # hello
        while len(got) < 10:
            assert hub.next <= len(got) * 4 + 3 * 4  # two in the mailbox, one just taken
            item = await client.get()
            assert item is not None
            got += told([wire.unpack(item.data)])
        await producing
        assert got == [("spokes", first, 4) for first in range(0, 40, 4)]

    run(test())


async def produce(hub: Hub, firsts: range) -> None:
    for first in firsts:
        await hub.publish(batch(first))


def test_a_lossless_client_that_does_not_read_is_let_go() -> None:
    async def test() -> None:
        hub, dead, alive = opened(patience=0.01), Client(U8, "lossless", messages=1), Client(U8)
        hub.join(dead)
        hub.join(alive)
        await produce(hub, range(0, 16, 4))
        assert told(await everything(alive)) == [("spokes", first, 4) for first in range(0, 16, 4)]
        last = await everything(dead)
        assert [m["type"] for m in last] == ["bye"] and "0.01 s" in last[0]["reason"]
        assert await dead.get() is None and dead.code == TOO_SLOW
        assert hub.clients == {alive}

    run(test())


@pytest.mark.parametrize("wanted", range(0, 13))
def test_since_goes_on_without_hole_or_double(wanted: int) -> None:
    async def test() -> None:
        hub, first = opened(), Client(U8)
        hub.join(first)
        await produce(hub, range(0, 12, 4))
        client = Client(U8)
        hub.join(client, ("e", wanted))
        await hub.publish(batch(12))
        got = await everything(client)
        numbers = [n for m in got[1:] for n in range(m["first"], m["first"] + m["count"])]
        assert numbers == list(range(wanted, 16)) and got[0]["type"] == "hello"
        for message in got[1:]:  # every list of a batch that was cut is cut alike
            rows = list(range(message["first"], message["first"] + message["count"]))
            assert message["time"] == message["azimuth"] == message["speed"] == rows and message["index"] == rows[0]
            assert list(message["data"]) == rows and message["position"] == [[n, n] for n in rows]

    run(test())


def test_what_is_no_longer_held_is_a_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hub_module, "HISTORY_BYTES", 2 * len(spokes(100, 4)) + 8)

    async def test() -> None:
        hub, first = opened(), Client(U8)
        hub.join(first)
        await produce(hub, range(100, 120, 4))
        client = Client(U8)
        hub.join(client, ("e", 102))
        assert told(await everything(client)) == [("gap", 102, 10), ("spokes", 112, 4), ("spokes", 116, 4)]

    run(test())


def test_a_view_that_nobody_had_starts_with_a_gap() -> None:
    async def test() -> None:
        hub, first = opened(), Client(U8)
        hub.join(first)
        await hub.publish(batch(0))
        client = Client(View("f32"))
        hub.join(client, ("e", 1))
        assert told(await everything(client)) == [("gap", 1, 3)]

    run(test())


def test_since_of_another_epoch_means_all_of_this_one() -> None:
    async def test() -> None:
        hub, first = opened(), Client(U8)
        hub.join(first)
        await hub.publish(batch(0))
        client = Client(U8)
        hub.join(client, ("earlier", 77))
        assert told(await everything(client)) == [("spokes", 0, 4)]

    run(test())


def test_history_ends_with_its_epoch() -> None:
    async def test() -> None:
        hub, first = opened(), Client(U8)
        hub.join(first)
        await hub.publish(batch(0))
        hub.open_epoch("f", lambda view, mode: wire.pack({"type": "hello", "epoch": "f"}))
        await hub.publish(batch(0, 2, "f"))
        for since in (("f", 0), ("e", 2)):
            client = Client(U8)
            hub.join(client, since)
            assert [m["epoch"] for m in await everything(client)] == ["f", "f"]

    run(test())


def test_a_batch_without_the_view_of_a_client_is_a_loss_only_to_who_was_there() -> None:
    async def test() -> None:
        hub, old, new = opened(), Client(U8), Client(View("f32"))
        hub.join(old)
        hub.join(new)
        await hub.publish(batch(0))  # encoded before f32 was asked for
        await hub.publish(batch(4, views=(U8, View("f32"))))
        await hub.publish(batch(8))
        assert told(await everything(new)) == [("spokes", 4, 4), ("gap", 8, 4)]

    run(test())


def test_all_clients_of_a_view_share_its_bytes() -> None:
    async def test() -> None:
        hub, clients = opened(), [Client(U8) for _ in range(3)]
        for client in clients:
            hub.join(client)
        await hub.publish(batch(0))
        items = []
        for client in clients:
            await client.get()
            items.append(await client.get())
        assert len({id(item.data) for item in items if item}) == 1 and hub.views == (U8,)

    run(test())


def test_truth_goes_ahead_of_its_spokes_to_who_asked() -> None:
    async def test() -> None:
        hub, asked, other = opened(), Client(U8, truth=True), Client(U8)
        hub.join(asked)
        hub.join(other)
        assert hub.truth_wanted
        await hub.publish(batch(0, truth=(wire.pack({"type": "truth", "epoch": "e"}),)))
        assert [m["type"] for m in await everything(asked)] == ["hello", "truth", "spokes"]
        assert [m["type"] for m in await everything(other)] == ["hello", "spokes"]
        hub.leave(asked)
        assert not hub.truth_wanted

    run(test())


def test_a_view_lingers_for_who_comes_back_and_then_goes() -> None:
    async def test() -> None:
        now = 0.0
        hub = Hub(lambda: now)
        hub.open_epoch("e", lambda view, mode: b"")
        client = Client(U8)
        hub.join(client)
        hub.leave(client)
        now = hub_module.LINGER
        await hub.publish(batch(0))
        assert hub.views == (U8,)
        now += 1.0
        await hub.publish(batch(4))
        assert hub.views == ()

    run(test())


def test_too_many_views_are_refused_until_one_is_idle() -> None:
    async def test() -> None:
        hub = opened()
        clients = [Client(View("u8", bins)) for bins in range(1, MAX_VIEWS + 1)]
        for client in clients:
            hub.join(client)
        with pytest.raises(Refused, match=f"{MAX_VIEWS} different views"):
            hub.join(Client(View("f32")))
        hub.leave(clients[3])
        hub.join(Client(View("f32")))
        assert View("f32") in hub.views and View("u8", 4) not in hub.views

    run(test())


def test_too_many_clients_are_refused() -> None:
    async def test() -> None:
        hub = opened(max_clients=1)
        hub.join(Client(U8))
        with pytest.raises(Refused, match="1 clients"):
            hub.join(Client(U8))

    run(test())


def test_before_its_first_epoch_a_radar_takes_no_clients() -> None:
    with pytest.raises(Refused, match="starting"):
        Hub(lambda: 0.0).join(Client(U8))


def test_who_never_reads_is_let_go_before_notices_fill_the_memory() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8)
        hub.join(client)
        for k in range(MAILBOX_NOTICES + 1):
            hub.open_epoch(str(k), lambda view, mode: wire.pack({"type": "hello", "epoch": "k"}))
        assert client.closed and [m["type"] for m in await everything(client)] == ["bye"]

    run(test())


def test_a_batch_of_an_epoch_that_is_over_is_ignored() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8)
        hub.join(client)
        await hub.publish(batch(0, epoch="old"))
        assert told(await everything(client)) == [] and hub.next == 0

    run(test())


def test_closing_says_bye_to_everybody() -> None:
    async def test() -> None:
        hub, client = opened(), Client(U8)
        hub.join(client)
        await hub.publish(batch(0))
        hub.close("that is all")
        assert await everything(client) == [{"type": "bye", "epoch": "e", "reason": "that is all"}]
        await client.over()

    run(test())


def test_who_has_lost_something_keeps_only_the_newest_until_it_has_caught_up() -> None:
    """Batches of 32 KiB: 64 of them fit; after a loss two do, which are 64 KiB."""

    async def whole() -> None:
        client, large = Client(View("u8")), bytes(32 * 1024)
        for k in range(64):
            client.put(Item(large, "e", k, 1, True))
        assert client.lost == 0
        client.put(Item(large, "e", 64, 1, True))
        assert [(item.first, item.count) for item in client._queue] == [(0, 63), (63, 1), (64, 1)]
        assert client.lost == 63 and client.gaps == 1
        await client.get()
        client.put(Item(large, "e", 65, 1, True))
        assert client.lost == 64  # it reads, but is still behind
        while client._queue:
            await client.get()
        for k in range(66, 66 + 64):
            client.put(Item(large, "e", k, 1, True))
        assert client.lost == 64 and client._bytes == 64 * len(large)

    asyncio.run(whole())


def test_a_message_goes_straight_to_a_client_that_waits_and_else_keeps_its_place() -> None:
    async def whole() -> None:
        client, written, room = Client(View("u8")), list[bytes](), True

        def write(frame: bytes) -> bool:
            written.extend([frame] if room else [])
            return room

        client.write = write
        items = [Item(bytes([k]), "e", k, 1, True) for k in range(7)]
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

    run(whole())
