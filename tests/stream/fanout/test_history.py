"""What a client that reconnects receives."""

import pytest

from radar_service.stream.codecs.native import wire
from radar_service.stream.fanout import history
from radar_service.stream.fanout.client_queue import ClientQueue
from radar_service.stream.feed_request import View
from tests.stream.fanout.batches import U8, batch, everything, numbered, opened, produce, run, spokes


@pytest.mark.parametrize("number", range(0, 13))
def test_since_goes_on_without_hole_or_double(number: int) -> None:
    async def test() -> None:
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

    run(test())


def test_what_is_no_longer_held_is_a_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(history, "HISTORY_BYTES", 2 * len(spokes(100, 4)) + 8)

    async def test() -> None:
        hub, first = opened(), ClientQueue(U8)
        hub.join(first)
        await produce(hub, range(100, 120, 4))
        client = ClientQueue(U8)
        hub.join(client, ("e", 102))
        assert numbered(await everything(client)) == [("gap", 102, 10), ("spokes", 112, 4), ("spokes", 116, 4)]

    run(test())


def test_a_view_holds_four_mebibytes() -> None:
    """As docs/feed.md and docs/promises.md say."""
    assert history.HISTORY_BYTES == 4 * 2**20


def test_a_view_that_nobody_had_starts_with_a_gap() -> None:
    async def test() -> None:
        hub, first = opened(), ClientQueue(U8)
        hub.join(first)
        await hub.publish(batch(0))
        client = ClientQueue(View("f32"))
        hub.join(client, ("e", 1))
        assert numbered(await everything(client)) == [("gap", 1, 3)]

    run(test())


def test_since_of_another_epoch_means_all_of_this_one() -> None:
    async def test() -> None:
        hub, first = opened(), ClientQueue(U8)
        hub.join(first)
        await hub.publish(batch(0))
        client = ClientQueue(U8)
        hub.join(client, ("earlier", 77))
        assert numbered(await everything(client)) == [("spokes", 0, 4)]

    run(test())


def test_history_ends_with_its_epoch() -> None:
    async def test() -> None:
        hub, first = opened(), ClientQueue(U8)
        hub.join(first)
        await hub.publish(batch(0))
        hub.open_epoch("f", lambda view, mode: wire.pack({"type": "hello", "epoch": "f"}))
        await hub.publish(batch(0, 2, "f"))
        for since in (("f", 0), ("e", 2)):
            client = ClientQueue(U8)
            hub.join(client, since)
            assert [m["epoch"] for m in await everything(client)] == ["f", "f"]

    run(test())
