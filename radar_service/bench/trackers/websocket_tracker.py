"""Trackers that are servers: JSON Lines over a websocket, one line in each text message."""

import socket
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from typing import Any

from typing_extensions import override
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI
from websockets.sync.client import connect

from radar_service.bench.trackers.json_lines import ANSWER_SECONDS, MAX_LINE, LineTracker, TrackerError

SCHEMES = ("ws://", "wss://")
CLOSE_SECONDS = 1.0  # that the tracker may take to say good-bye


class WebsocketTracker(LineTracker):
    """A LineTracker that listens at an address. No pings are sent: a tracker may compute for as long as an answer may take."""

    def __init__(self, url: str, header: Mapping[str, Any], timeout: float = ANSWER_SECONDS) -> None:
        """url: ws:// or wss://; timeout: to connect and for each answer [s]. Raises TrackerError."""
        super().__init__(url, timeout)
        self._ending = ExitStack()
        try:
            opening = connect(
                url, open_timeout=timeout, close_timeout=CLOSE_SECONDS, ping_interval=None, compression=None,
                max_size=MAX_LINE, max_queue=1,
            )  # fmt: skip
            self._connection = self._ending.enter_context(opening)
        except (OSError, InvalidHandshake, InvalidURI, ValueError, EOFError) as error:
            raise TrackerError(f"tracker: {url} could not be reached: {error or type(error).__name__}") from None
        self.begin(header)

    @override
    def write(self, line: str) -> None:
        self._connection.send(line)

    @override
    def answer(self, scan: int) -> str:
        try:
            message = self._connection.recv(self.timeout)
        except TimeoutError:
            raise self.silent(scan) from None
        except ConnectionClosed as error:
            raise TrackerError(
                f"tracker: {self.name} closed the connection before it answered scan {scan}: {error}"
            ) from None
        if not isinstance(message, str):
            raise TrackerError(f"tracker: the answer to scan {scan} is not understood: it is a binary message, not text")
        return message

    def close(self) -> None:
        """Ends the connection, at once where the tracker does not read."""
        if self.is_stuck:
            with suppress(OSError):
                self._connection.socket.shutdown(socket.SHUT_RDWR)
        self._ending.close()
