"""The bridge from a thread to the hub: every call is done when it returns."""

import asyncio

from radar_service.stream.codecs.native import wire
from radar_service.stream.fanout.client_queue import ClientQueue
from radar_service.stream.fanout.feed_output import FeedOutput
from radar_service.stream.fanout.hub import Hub
from tests.stream.fanout.batches import U8, batch, run


def test_calls_of_another_thread_reach_the_hub_in_order() -> None:
    async def test() -> None:
        hub = Hub(lambda: 0.0)
        output = FeedOutput(hub)
        output.start()
        await asyncio.to_thread(output.open_epoch, "e", lambda view, mode: b"\x81\xa4type\xa5hello", 0.01)
        hub.join(client := ClientQueue(U8, truth=True))
        assert output.views == (U8,)

        def transmit() -> None:
            output.publish(batch(0))
            assert hub.next == 4
            output.skip("e", 4, 5, "it broke")
            assert hub.next == 9
            output.close("that is all")

        transmitting = asyncio.create_task(asyncio.to_thread(transmit))
        kinds = []
        while (item := await client.get()) is not None:
            assert not transmitting.done()  # it waits for who has yet to read
            kinds.append(wire.unpack(item.data)["type"])
        hub.leave(client)
        await transmitting
        assert kinds == ["hello", "spokes", "gap", "bye"]

    run(test())
