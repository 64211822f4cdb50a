"""Conversations by websocket: their parts end together, and reasons fit a close frame."""

import asyncio

from radar_service.ports.http.conversation import close_reason, until_first_ends


def test_the_first_part_that_ends_ends_the_others() -> None:
    ended = []

    async def part(name: str, event: asyncio.Event) -> None:
        try:
            await event.wait()
        finally:
            ended.append(name)

    async def body() -> None:
        first, never = asyncio.Event(), asyncio.Event()
        first.set()
        await asyncio.wait_for(until_first_ends(part("reads", never), part("writes", first)), 10)

    asyncio.run(body())
    assert ended == ["writes", "reads"]


def test_a_reason_fits_a_close_frame_whatever_its_letters() -> None:
    """A control frame holds 125 bytes, two of them the close code (RFC 6455, section 5.5)."""
    assert close_reason("range: 5 m") == "range: 5 m"
    for letter in ("x", "é", "日", "🚢"):
        reason = close_reason(letter * 200)
        assert 116 < len(reason.encode()) <= 123 and set(reason) == {letter}
