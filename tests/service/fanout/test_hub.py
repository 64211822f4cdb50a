"""The hub without a socket: every loss is announced, nothing comes twice, a slow live client delays no other."""

import asyncio

import pytest

from radar_service import wire
from radar_service.service.fanout import hub as hub_module
from radar_service.service.fanout.client_queue import FULL, TOO_SLOW, ClientQueue
from radar_service.service.fanout.hub import (
    FLOOR,
    MAX_OWN_VIEWS,
    MAX_VIEWS,
    WINDOW,
    DelayAccount,
    FeedRefused,
    Hub,
    own_views,
    view_to_give,
)
from radar_service.service.feed_request import View
from tests.service.fanout.batches import U8, batch, everything, numbered, opened, produce, spokes


async def test_a_slow_client_loses_the_oldest_batches_and_receives_their_numbers() -> None:
    hub, client = opened(), ClientQueue(U8, messages=3)
    hub.join(client)
    for first in range(0, 40, 4):
        await hub.publish(batch(first))
    got = await everything(client)
    assert numbered(got) == [("gap", 0, 28), ("spokes", 28, 4), ("spokes", 32, 4), ("spokes", 36, 4)]
    assert got[1]["reason"] == "this client is too slow" and client.lost == 28 and hub.totals().bytes == client.bytes > 0


async def test_a_slow_client_does_not_hold_up_a_fast_one() -> None:
    hub, slow, fast = opened(), ClientQueue(U8, messages=1), ClientQueue(U8, messages=1)
    hub.join(slow)
    hub.join(fast)
    got = []
    for first in range(0, 40, 4):
        await hub.publish(batch(first))
        got += numbered(await everything(fast))
    assert got == [("spokes", first, 4) for first in range(0, 40, 4)]
    assert (fast.lost, slow.lost) == (0, 36)


async def test_a_lossless_client_makes_the_producer_wait() -> None:
    hub, client = opened(), ClientQueue(U8, "lossless", messages=2)
    hub.join(client)
    producing = asyncio.ensure_future(produce(hub, range(0, 40, 4)))
    got: list[tuple[str, int, int]] = []
    await client.get()  # hello
    while len(got) < 10:
        assert hub.next <= len(got) * 4 + 3 * 4  # two in the queue, one just taken
        item = await client.get()
        assert item is not None
        got += numbered([wire.unpack(item.data)])
    await producing
    assert got == [("spokes", first, 4) for first in range(0, 40, 4)]


async def test_a_lossless_client_that_does_not_read_is_let_go() -> None:
    hub, dead, alive = opened(patience=0.01), ClientQueue(U8, "lossless", messages=1), ClientQueue(U8)
    hub.join(dead)
    hub.join(alive)
    await produce(hub, range(0, 16, 4))
    assert numbered(await everything(alive)) == [("spokes", first, 4) for first in range(0, 16, 4)]
    await dead.ended()
    last = [wire.unpack(item.data) for item in dead.rest()]
    assert [m["type"] for m in last] == ["hello", "gap", "bye"] and "0.01 s" in last[2]["reason"]
    assert numbered(last) == [("gap", 0, 4)]  # what the hub had when it let go
    assert await dead.get() is None and dead.code == TOO_SLOW
    assert hub.clients == {alive}


@pytest.mark.parametrize("alone", [False, True])
async def test_a_lossless_client_that_trickles_is_let_go_where_others_wait(alone: bool) -> None:
    """It reads one batch in three seconds, so patience never ends."""
    now = [0.0]
    hub, slow, other = Hub(lambda: now[0]), ClientQueue(U8, "lossless", messages=1), ClientQueue(U8)
    hub.open_epoch("e", lambda view, mode: b"", spoke_period=0.01)
    hub.join(slow)
    if not alone:
        hub.join(other)

    async def trickle() -> None:
        while (await slow.get()) is not None:
            now[0] += 3.0
            for _ in range(5):  # turns of the loop, for the producer to go on
                await asyncio.sleep(0)

    reading = asyncio.ensure_future(trickle())
    await produce(hub, range(0, 80, 4))
    assert (slow in hub.clients) == alone and slow.closed != alone
    if not alone:
        await reading
        assert slow.code == TOO_SLOW and 9.0 <= slow.delivered / 4 * 3.0 <= 24.0
    reading.cancel()


async def test_a_batch_without_the_view_of_a_client_is_a_loss_only_to_who_was_there() -> None:
    hub, old, new = opened(), ClientQueue(U8), ClientQueue(View("f32"))
    hub.join(old)
    hub.join(new)
    await hub.publish(batch(0))  # encoded before f32 was requested
    await hub.publish(batch(4, views=(U8, View("f32"))))
    await hub.publish(batch(8))
    assert numbered(await everything(new)) == [("spokes", 4, 4), ("gap", 8, 4)]


async def test_all_clients_of_a_view_share_its_bytes() -> None:
    hub, clients = opened(), [ClientQueue(U8) for _ in range(3)]
    for client in clients:
        hub.join(client)
    await hub.publish(batch(0))
    items = []
    for client in clients:
        await client.get()
        items.append(await client.get())
    assert len({id(item.data) for item in items if item}) == 1 and hub.views == (U8,)


async def test_truth_goes_to_clients_that_requested_it() -> None:
    hub, with_truth, other = opened(), ClientQueue(U8, truth=True), ClientQueue(U8)
    hub.join(with_truth)
    hub.join(other)
    assert hub.truth_codecs == ("native",)
    state = wire.pack({"type": "truth", "epoch": "e"})
    await hub.publish(batch(0))
    hub.tell("e", [("native", state), ("another", state)])
    hub.tell("the epoch before", [("native", state)])
    assert [m["type"] for m in await everything(with_truth)] == ["hello", "spokes", "truth"]
    assert [m["type"] for m in await everything(other)] == ["hello", "spokes"]
    hub.leave(with_truth)
    assert hub.truth_codecs == ()


async def test_a_view_stays_for_clients_that_reconnect_and_is_then_removed() -> None:
    now = 0.0
    hub = Hub(lambda: now)
    hub.open_epoch("e", lambda view, mode: b"")
    client = ClientQueue(U8)
    hub.join(client)
    hub.leave(client)
    now = hub_module.LINGER
    await hub.publish(batch(0))
    assert hub.views == (U8,)
    now += 1.0
    await hub.publish(batch(4))
    assert hub.views == ()


async def test_too_many_views_are_refused_until_one_is_idle() -> None:
    hub = opened()
    clients = [ClientQueue(View("u8", bins)) for bins in range(1, MAX_VIEWS + 1)]
    for client in clients:
        hub.join(client)
    with pytest.raises(FeedRefused, match=f"{MAX_VIEWS} different views"):
        hub.join(ClientQueue(View("f32")))
    hub.leave(clients[3])
    hub.join(ClientQueue(View("f32")))
    assert View("f32") in hub.views and View("u8", 4) not in hub.views


async def test_too_many_clients_are_refused() -> None:
    hub = opened(max_clients=1)
    hub.join(ClientQueue(U8))
    with pytest.raises(FeedRefused, match="1 clients"):
        hub.join(ClientQueue(U8))


def test_before_its_first_epoch_a_radar_takes_no_clients() -> None:
    with pytest.raises(FeedRefused, match="starting"):
        Hub(lambda: 0.0).join(ClientQueue(U8))


async def test_a_batch_of_an_epoch_that_is_over_is_ignored() -> None:
    hub, client = opened(), ClientQueue(U8)
    hub.join(client)
    await hub.publish(batch(0, epoch="old"))
    assert numbered(await everything(client)) == [] and hub.next == 0


async def test_closing_says_bye_to_everybody() -> None:
    hub, client = opened(), ClientQueue(U8)
    hub.join(client)
    await hub.publish(batch(0))
    hub.close("that is all")
    await hub.publish(batch(4))
    got = await everything(client)
    assert numbered(got) == [("spokes", 0, 4)]
    assert got[-1] == {"type": "bye", "epoch": "e", "reason": "that is all"} and await client.get() is None


@pytest.mark.parametrize("number", range(0, 13))
async def test_since_goes_on_without_hole_or_double(number: int) -> None:
    hub, first = opened(), ClientQueue(U8)
    hub.join(first)
    await produce(hub, range(0, 12, 4))
    client = ClientQueue(U8)
    hub.join(client, ("e", number))
    await hub.publish(batch(12))
    got = await everything(client)
    numbers = [n for m in got[1:] for n in range(m["first"], m["first"] + m["count"])]
    assert numbers == list(range(number, 16)) and got[0]["type"] == "hello"
    for message in got[1:]:  # every list of a batch that was cut is cut alike
        rows = list(range(message["first"], message["first"] + message["count"]))
        assert message["time"] == message["azimuth"] == message["speed"] == rows and message["index"] == rows[0]
        assert list(message["data"]) == rows and message["position"] == [[n, n] for n in rows]


async def test_what_is_no_longer_held_is_a_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hub_module, "HISTORY_BYTES", 2 * len(spokes(100, 4)) + 8)
    hub, first = opened(), ClientQueue(U8)
    hub.join(first)
    await produce(hub, range(100, 120, 4))
    client = ClientQueue(U8)
    hub.join(client, ("e", 102))
    assert numbered(await everything(client)) == [("gap", 102, 10), ("spokes", 112, 4), ("spokes", 116, 4)]


def test_a_view_holds_four_mebibytes() -> None:
    """As docs/feed.md and docs/accuracy.md say."""
    assert hub_module.HISTORY_BYTES == 4 * 2**20


async def test_a_view_that_nobody_had_starts_with_a_gap() -> None:
    hub, first = opened(), ClientQueue(U8)
    hub.join(first)
    await hub.publish(batch(0))
    client = ClientQueue(View("f32"))
    hub.join(client, ("e", 1))
    assert numbered(await everything(client)) == [("gap", 1, 3)]


async def test_history_ends_with_its_epoch() -> None:
    hub, first = opened(), ClientQueue(U8)
    hub.join(first)
    await hub.publish(batch(0))
    hub.open_epoch("f", lambda view, mode: wire.pack({"type": "hello", "epoch": "f"}))
    await hub.publish(batch(0, 2, "f"))
    for since in (("f", 0), ("e", 2)):
        client = ClientQueue(U8)
        hub.join(client, since)
        assert [m["epoch"] for m in await everything(client)] == ["f", "f"]


def queue(bins: int, owner: str) -> ClientQueue:
    return ClientQueue(View("u8", bins), owner=owner)


def test_views_that_others_have_too_are_nobodys_own() -> None:
    clients = [queue(1, "a"), queue(2, "a"), queue(3, "a"), queue(2, "b"), queue(3, "a"), queue(1, "a")]
    assert own_views(clients) == {"a": [View("u8", 3), View("u8", 1)]}
    assert view_to_give(clients, "c") == View("u8", 1) and view_to_give(clients, "a") is None
    assert view_to_give([queue(1, "a")], "b") is None and view_to_give([], "b") is None


def joined(hub: Hub, bins: range, owner: str) -> list[ClientQueue]:
    clients = [queue(n, owner) for n in bins]
    for client in clients:
        hub.join(client)
    return clients


async def test_one_address_has_a_bounded_number_of_views() -> None:
    hub = opened()
    joined(hub, range(1, MAX_OWN_VIEWS + 1), "a")
    with pytest.raises(FeedRefused, match=f"your address has {MAX_OWN_VIEWS} views"):
        hub.join(queue(99, "a"))
    hub.join(queue(3, "a"))  # a view that it has
    joined(hub, range(101, 104), "b")
    hub.join(queue(101, "a"))  # a view that somebody else has
    assert len(hub.views) == MAX_OWN_VIEWS + 3


async def test_a_newcomer_gets_a_view_of_the_address_that_has_the_most() -> None:
    hub = opened()
    many = joined(hub, range(1, MAX_OWN_VIEWS + 1), "a")
    joined(hub, range(101, 101 + MAX_VIEWS - MAX_OWN_VIEWS), "b")
    hub.leave(hub_client := next(client for client in hub.clients if client.view == View("u8", 101)))
    hub.join(queue(201, "c"))  # takes the idle view
    assert hub_client.view not in hub.views
    hub.join(queue(202, "c"))
    assert View("u8", 202) in hub.views and len(hub.views) == MAX_VIEWS
    assert many[-1].closed and many[-1].code == FULL and many[-1] not in hub.clients
    assert "another address needs a view" in (await everything(many[-1]))[-1]["reason"]
    assert not any(client.closed for client in many[:-1])
    with pytest.raises(FeedRefused, match="views are being served"):
        for bins in range(203, 230):
            hub.join(queue(bins, "c"))
    shares = {owner: len(views) for owner, views in own_views(hub.clients).items()}
    assert max(shares.values()) - min(shares.values()) <= 2 and sum(shares.values()) == MAX_VIEWS


PERIOD = 0.01  # s


@pytest.mark.parametrize(
    ("waited", "share", "slow"),
    [(0.9, 0.9 * FLOOR, True), (0.9, 1.1 * FLOOR, False), (0.4, 0.1 * FLOOR, False), (0.9, 0.0, True)],
)
def test_a_client_is_slow_that_is_waited_for_and_takes_too_little(waited: float, share: float, slow: bool) -> None:
    account = DelayAccount(100.0, 50)
    account.add(waited * WINDOW)
    got = 50 + round(share * WINDOW / PERIOD)
    assert not account.is_too_slow(100.0 + 0.99 * WINDOW, got, PERIOD)
    assert account.is_too_slow(100.0 + WINDOW, got, PERIOD) == slow
    assert not account.is_too_slow(100.0 + 1.5 * WINDOW, got, PERIOD)  # a new window has begun


def test_a_good_hour_does_not_count_for_a_bad_minute() -> None:
    account = DelayAccount(0.0, 0)
    account.add(1.0)
    assert not account.is_too_slow(3600.0, 360_000, PERIOD)
    account.add(0.9 * WINDOW)
    assert account.is_too_slow(3600.0 + WINDOW, 360_000, PERIOD)
