"""The bridge from a thread to the hub: every call is done when it returns."""

import asyncio

from radar_service.stream.fanout.client_queue import ClientQueue
from radar_service.stream.fanout.feed_output import FeedOutput
from radar_service.stream.fanout.hub import Hub
from tests.stream.fanout.batches import U8, batch, everything, run


def test_calls_of_another_thread_reach_the_hub_in_order() -> None:
    async def test() -> None:
        hub = Hub(lambda: 0.0)
        output = FeedOutput(hub)
        output.start()
        await asyncio.to_thread(output.open_epoch, "e", lambda view, mode: b"\x81\xa4type\xa5hello", 0.01)
        hub.join(client := ClientQueue(U8, truth=True))
        assert (output.views, output.truth_codecs) == ((U8,), ("native",))

        def transmit() -> None:
            output.publish(batch(0))
            assert hub.next == 4
            output.skip("e", 5, "it broke")
            assert hub.next == 9
            output.close("that is all")

        await asyncio.to_thread(transmit)
        assert client.closed and [message["type"] for message in await everything(client)] == ["bye"]

    run(test())
