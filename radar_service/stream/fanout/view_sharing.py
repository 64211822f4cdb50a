"""Who may have how many of a radar's views. An owner is the address of the machine that clients come from."""

from collections import defaultdict
from collections.abc import Iterable

from radar_service.stream.fanout.client_queue import ClientQueue
from radar_service.stream.feed_request import View

MAX_OWN_VIEWS = 8  # of one address, not counting those that clients of other addresses have too


def own_views(clients: Iterable[ClientQueue]) -> dict[str, list[View]]:
    """Returns for each owner the views that only it has, the one with the newest client last."""
    owners: dict[View, set[str]] = defaultdict(set)
    newest: dict[View, int] = {}
    for client in clients:
        owners[client.view].add(client.owner)
        newest[client.view] = max(client.number, newest.get(client.view, 0))
    views: dict[str, list[View]] = defaultdict(list)
    for view in sorted(newest, key=newest.__getitem__):
        if len(owners[view]) == 1:
            views[next(iter(owners[view]))].append(view)
    return views


def view_to_give(clients: Iterable[ClientQueue], owner: str) -> View | None:
    """Returns the view that the owner with the most gives up for `owner`; None where that one would not have fewer."""
    views = own_views(clients)
    most = max(views, key=lambda other: len(views[other]), default="")
    return views[most][-1] if most != owner and len(views[most]) > len(views[owner]) + 1 else None
