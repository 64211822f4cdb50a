"""Errors of a feed say why it ended and whether another attempt may succeed."""

import socket

import pytest

from clients.ppi import FeedClient, FeedError
from tests.clients.fake_feed import GREETING, Script, batch, hello, running
from tests.clients.received import final_error, numbers


@pytest.mark.parametrize(
    ("script", "text", "retry"),
    [
        (Script([GREETING, {"type": "bye", "epoch": "a", "reason": "the service stops"}]), "the service stops", True),
        (Script([{"type": "bye", "epoch": "", "reason": "no such bins"}], code=4400), "refused: no such bins", False),
        (Script([GREETING], code=1011), "1011", True),
        (Script([GREETING | {"protocol": 99}]), "protocol 99", False),
        (Script([b"rubbish"]), "not a message", False),
        (Script(["text"]), "not a message", False),
        (Script([GREETING, {"type": "spokes", "epoch": "a"}]), "'count'", False),
        (Script([GREETING, batch(0, 2) | {"count": 3}]), "3 spokes with 2 azimuths", False),
        (Script([GREETING, batch(0, 2) | {"data": b"short"}]), "5 bytes", False),
        (Script([batch(0, 2)]), "without its hello", False),
        (Script([GREETING, batch(0, 2, hello("z"))]), "without its hello", False),
    ],
)
def test_a_feed_that_ends_says_why(script: Script, text: str, retry: bool) -> None:
    with running(script) as feed, pytest.raises(FeedError, match=text) as fault:
        numbers(feed.url, 10)
    assert fault.value.retry is retry and feed.url in str(fault.value)


def test_errors_distinguish_no_service_from_no_such_radar() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # bound and not listening: refuses
        fault = final_error(f"ws://127.0.0.1:{taken.getsockname()[1]}", reconnect=True, backoff=(0.0,))
    assert (
        "is the service running" in str(fault) and fault.retry
    )  # the client did not retry by itself: it never was connected
    with running() as feed:
        fault = final_error(f"{feed.url}/api/radars/9/feed")
        assert "no such radar" in str(fault) and feed.url.replace("ws", "http") + "/api/radars lists" in str(fault)
        assert not fault.retry
        fault = final_error(f"{feed.url}/api/radars/5/feed")
        assert "HTTP 500: the engine died" in str(fault) and fault.retry
    with pytest.raises(ValueError, match='"u9" is not one of u8'):
        FeedClient("ws://h", encoding="u9")
