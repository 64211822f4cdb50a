"""Batches and queues for tests of the fan-out."""

from typing import Any

from radar_service import wire
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import EncodedBatch, Hub
from radar_service.service.feed_request import View

U8 = View("u8")


def spokes(first: int, count: int, epoch: str = "e", size: int = 1) -> bytes:
    row = list(range(first, first + count))
    return wire.pack(
        {"type": "spokes", "epoch": epoch, "first": first, "count": count, "index": first, "time": row, "azimuth": row,
         "heading": row, "position": [[n, n] for n in row], "course": row, "speed": row,
         "data": bytes(n % 256 for n in row for _ in range(size))}
    )  # fmt: skip


def batch(first: int, count: int = 4, epoch: str = "e", views: tuple[View, ...] = (U8,), **more: Any) -> EncodedBatch:
    return EncodedBatch(epoch, first, count, {view: spokes(first, count, epoch) for view in views}, **more)


def opened(**options: Any) -> Hub:
    hub = Hub(lambda: 0.0, **options)
    hub.open_epoch("e", lambda view, mode: wire.pack({"type": "hello", "epoch": "e", "view": view.encoding}))
    return hub


async def everything(client: ClientQueue) -> list[dict[str, Any]]:
    """Takes all messages of the queue."""
    messages = []
    while client.waiting:
        item = await client.get()
        assert item is not None
        messages.append(wire.unpack(item.data))
    return messages


def numbered(messages: list[dict[str, Any]]) -> list[tuple[str, int, int]]:
    """Type, first and count of the messages that carry numbers."""
    return [(m["type"], m["first"], m["count"]) for m in messages if "first" in m]


async def produce(hub: Hub, firsts: range) -> None:
    for first in firsts:
        await hub.publish(batch(first))
