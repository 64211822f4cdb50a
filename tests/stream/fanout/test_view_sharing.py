"""One address with many views leaves some for others."""

import pytest

from radar_service.stream.fanout.client_queue import FULL, ClientQueue
from radar_service.stream.fanout.hub import MAX_VIEWS, FeedRefused, Hub
from radar_service.stream.fanout.view_sharing import MAX_OWN_VIEWS, own_views, view_to_give
from radar_service.stream.feed_request import View
from tests.stream.fanout.batches import everything, opened, run


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


def test_one_address_has_a_bounded_number_of_views() -> None:
    async def test() -> None:
        hub = opened()
        joined(hub, range(1, MAX_OWN_VIEWS + 1), "a")
        with pytest.raises(FeedRefused, match=f"your address has {MAX_OWN_VIEWS} views"):
            hub.join(queue(99, "a"))
        hub.join(queue(3, "a"))  # a view that it has
        joined(hub, range(101, 104), "b")
        hub.join(queue(101, "a"))  # a view that somebody else has
        assert len(hub.views) == MAX_OWN_VIEWS + 3

    run(test())


def test_a_newcomer_gets_a_view_of_the_address_that_has_the_most() -> None:
    async def test() -> None:
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

    run(test())
