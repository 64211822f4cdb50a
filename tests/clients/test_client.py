"""The client against a scripted feed on loopback: options, repeats, losses, reconnection."""

import asyncio

import pytest

from clients.ppi import FeedClient, FeedError, SequenceTracker, spokes
from clients.ppi.spoke import ReceivedSpoke
from tests.clients.fake_feed import GREETING, Script, batch, final_error, gap, hello, numbers, running


def test_options_reach_the_radar() -> None:
    with running(Script([GREETING, batch(5, 1)])) as feed:
        assert numbers(feed.url, 1, encoding="f32", bins=50, truth=True, mode="lossless", since=("a", 5)) == [5]
    assert feed.queries == [{"encoding": "f32", "bins": "50", "truth": "1", "mode": "lossless", "since": "a:5"}]
    with running(Script([GREETING, batch(5, 1)]), Script([GREETING, batch(5, 1)])) as feed:
        assert numbers(feed.url, 1, labels=True, powers=(257, 1)) == numbers(feed.url, 1, powers="all") == [5]
    assert [(query.get("labels"), query["powers"]) for query in feed.queries] == [("1", "257,1"), (None, "all")]


def test_repeated_spokes_are_yielded_once() -> None:
    with running(Script([GREETING, batch(0, 4), batch(2, 4), batch(1, 3), batch(6, 1)])) as feed:
        assert numbers(feed.url, 7) == [0, 1, 2, 3, 4, 5, 6]


def test_no_spoke_is_written_out_on_its_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """asyncio.Runner formats the task that it ran: with a spoke as its result, that took a hundred times the rest."""
    written: list[ReceivedSpoke] = []
    monkeypatch.setattr(ReceivedSpoke, "__repr__", lambda self: str(written.append(self)))
    with running(Script([GREETING, batch(0, 4)])) as feed:
        assert numbers(feed.url, 4) == [0, 1, 2, 3]
    assert written == []


def test_client_reconnects_and_continues_with_the_next_number() -> None:
    other = hello("b")
    scripts = (
        Script([GREETING, batch(10, 4)], code=1011),
        Script([GREETING, batch(14, 2)]),
        Script([other, gap(other, 0, 3), batch(3, 2, other)]),
    )
    client_of: dict[str, FeedClient] = {}

    async def follow(url: str) -> list[tuple[str, int]]:
        client = client_of["it"] = FeedClient(url, reconnect=True, timeout=10.0, backoff=(0.0,))
        received: list[tuple[str, int]] = []
        async with client:
            async for spoke in client.spokes():
                received.append((spoke.epoch, spoke.number))
                if len(received) == 8:
                    break
        return received

    with running(*scripts) as feed:
        received = asyncio.run(follow(feed.url))
    assert received == [("a", n) for n in range(10, 16)] + [("b", 3), ("b", 4)]
    assert [query.get("since") for query in feed.queries] == [None, "a:14", "a:16"]
    sequence = client_of["it"].sequence
    assert (sequence.announced, sequence.missing, sequence.received, client_of["it"].reconnections) == (3, 0, 8, 2)


def test_missing_beginning_of_a_later_epoch_counts_as_lost() -> None:
    other = hello("b")

    async def follow(url: str) -> SequenceTracker:
        client = FeedClient(url, timeout=10.0)
        with pytest.raises(FeedError):
            async for _ in client.spokes():
                pass
        return client.sequence

    with running(Script([GREETING, batch(10, 4), other, batch(2, 2, other)])) as feed:
        sequence = asyncio.run(follow(feed.url))
    assert (sequence.missing, sequence.received, sequence.epochs) == (2, 6, 2)


def test_missing_beginning_counts_as_lost_for_a_client_with_since() -> None:
    async def follow(url: str, since: tuple[str, int] | None) -> SequenceTracker:
        async with FeedClient(url, timeout=10.0, since=since) as client:
            await anext(client.spokes())
            return client.sequence

    for since, missing in ((("z", 9), 3), (None, 0)):
        with running(Script([GREETING, batch(3, 1)])) as feed:
            assert asyncio.run(follow(feed.url, since)).missing == missing


def test_silence_ends_a_feed() -> None:
    with running(Script([GREETING], wait=True)) as feed, pytest.raises(FeedError, match="no message for 0.05 s") as fault:
        list(spokes(feed.url, timeout=0.05))
    assert fault.value.retry


def test_client_does_not_repeat_a_refused_request() -> None:
    scripts = (Script([GREETING, batch(0, 1)]), Script([{"type": "bye", "epoch": "", "reason": "full"}], code=4403))
    with running(*scripts) as feed:
        assert "refused: full" in str(final_error(feed.url, reconnect=True, backoff=(0.0,)))
    assert len(feed.queries) == 2


def test_leaving_the_loop_closes_the_connection() -> None:
    with running(Script([GREETING, batch(0, 5)], wait=True)) as feed:
        assert numbers(feed.url, 2) == [0, 1]
        assert feed.left.wait(60)


def test_client_stops_reconnecting_after_its_patience() -> None:
    notices: list[str] = []
    with running(Script([GREETING, batch(0, 30)])) as feed:  # the second connection finds no script
        fault = final_error(feed.url, reconnect=True, patience=0.4, backoff=(0.25,), notice=notices.append)
    assert "ended the feed" in str(fault) and len(feed.queries) == 2
    assert notices == ["the radar ended the feed: no reason given (close code 1001); trying again in 0.25 s"]
