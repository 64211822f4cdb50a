"""Trackers that are servers: JSON Lines over a websocket on loopback, and every way in which they go wrong."""

import json
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve

from radar_service.bench.trackers import websocket_tracker
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.websocket_tracker import WebsocketTracker
from tests.bench.trackers.test_stone_soup import given, plot

Handler = Callable[[ServerConnection], None]


def plots_as_tracks(connection: ServerConnection) -> None:
    """Answers each plot as a track at rest; the seed of the header is its velocity north."""
    header = json.loads(connection.recv())
    for line in connection:
        scan = json.loads(line)
        tracks = [
            {"track": k, "time": p["time"], "east": p["east"], "north": p["north"], "velocity_east": 0,
             "velocity_north": header["seed"]}
            for k, p in enumerate(scan["plots"])
        ]  # fmt: skip
        connection.send(json.dumps({"type": "tracks", "scan": scan["scan"], "tracks": tracks}))


@contextmanager
def server(handler: Handler) -> Iterator[str]:
    """A tracker on a free port of this machine, and its address."""
    with serve(handler, "127.0.0.1", 0, max_size=None) as listening:
        thread = threading.Thread(target=listening.serve_forever)
        thread.start()
        try:
            yield f"ws://127.0.0.1:{listening.socket.getsockname()[1]}/tracks"
        finally:
            listening.shutdown()
            thread.join()


def test_a_server_gets_plots_and_gives_tracks() -> None:
    with server(plots_as_tracks) as url:
        trackers = [WebsocketTracker(url, {"scenario": "s", "seed": seed}) for seed in (7, 8)]  # each run has its own
        for scan in range(3):
            for seed, tracker in zip((7, 8), trackers, strict=True):
                (state,) = tracker.update(given(scan, (plot(scan * 2.5 + 1, 100.0, 200.0),)))
                assert (state.track, state.time, state.east, state.north) == ("0", scan * 2.5 + 1, 100.0, 200.0)
                assert state.velocity_north == seed
        for tracker in trackers:
            tracker.close()


def answers(*lines: str | bytes) -> Handler:
    def handler(connection: ServerConnection) -> None:
        connection.recv()  # the header
        for _ in connection:
            for line in lines:
                connection.send(line)

    return handler


def leaves(connection: ServerConnection) -> None:
    connection.recv()
    connection.recv()
    connection.close(1011, "out of memory")


def silent(connection: ServerConnection) -> None:
    for _ in connection:
        pass


EMPTY = json.dumps({"type": "tracks", "scan": 0, "tracks": []})


@pytest.mark.parametrize(
    ("handler", "words"),
    [
        (leaves, "closed the connection before it answered scan 0: .*out of memory"),
        (answers(EMPTY.encode()), "is a binary message, not text"),
        (answers("x" * 2000), "closed the connection before it answered scan 0: .*1009"),
        (silent, "no answer \\(a line, flushed\\) to scan 0 within 0.2 s"),
    ],
    ids=["leaves", "binary", "too long", "silent"],
)  # fmt: skip
def test_what_goes_wrong_is_said(handler: Handler, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket_tracker, "MAX_LINE", 1000)
    with server(handler) as url:
        tracker = WebsocketTracker(url, {"seed": 0}, timeout=20.0)
        tracker.timeout = 0.2 if handler is silent else 20.0  # connected at leisure
        with pytest.raises(TrackerError, match=words):
            for scan in range(3):
                tracker.update(given(scan, ()))
        tracker.close()


def test_a_server_that_reads_nothing_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """More plots than the buffers of both ends take: the bench does not wait, and closing ends the connection."""
    gone, may_end, was_told = threading.Event(), threading.Event(), []

    def deaf(connection: ServerConnection) -> None:
        was_told.append(may_end.wait(20.0))  # not before the bench has closed
        with pytest.raises(ConnectionClosed):
            for _ in connection:
                pass
            connection.send("")
        gone.set()

    with server(deaf) as url:
        tracker = WebsocketTracker(url, {"seed": 0}, timeout=20.0)
        for _ in range(16):
            tracker.send({"plots": "x"})  # a queue of frames that nobody takes: the other end stops reading its socket
        tracker.timeout = 0.5  # connected at leisure
        with pytest.raises(TrackerError, match="read no plots for 0.5 s"):
            for _ in range(100):
                tracker.send({"plots": "x" * 2_000_000})
        tracker.close()
        may_end.set()
        assert gone.wait(60) and was_told == [True]


def test_an_address_without_a_tracker_is_refused() -> None:
    with socket.socket() as taken:  # bound, not listening
        taken.bind(("127.0.0.1", 0))
        with pytest.raises(TrackerError, match="tracker: ws://127.0.0.1:.* could not be reached: .*refused"):
            WebsocketTracker(f"ws://127.0.0.1:{taken.getsockname()[1]}", {})
    with pytest.raises(TrackerError, match="ws:// could not be reached"):
        WebsocketTracker("ws://", {})


def test_a_server_that_speaks_no_websocket_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def http() -> None:
            connection, _ = listening.accept()
            with connection:
                connection.recv(4096)
                connection.sendall(b"HTTP/1.1 404 Not Found\r\ncontent-length: 0\r\n\r\n")

        thread = threading.Thread(target=http)
        thread.start()
        with pytest.raises(TrackerError, match="could not be reached: .*404"):
            WebsocketTracker(f"ws://127.0.0.1:{listening.getsockname()[1]}", {})
        thread.join()


def test_a_server_that_never_answers_the_handshake_is_let_go() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening, pytest.raises(TrackerError, match="could not be reached: "):
        WebsocketTracker(f"ws://127.0.0.1:{listening.getsockname()[1]}", {}, timeout=0.1)
