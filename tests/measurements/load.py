"""Many clients of one feed in a process of their own: python -m tests.measurements.load HOST PORT CLIENTS SECONDS STALLED QUERY.

Loopback only. Every message is checked for holes and doubles; lateness is that of its last spoke against the best of the
run, so that it holds the queueing but not the batch. It counts from SETTLING on: the first clients read nothing while the
others connect. The stalled ones read nothing until the end, and then all that was
kept for them. Prints a line of JSON.
"""

import json
import selectors
import socket
import struct
import sys
import time
from functools import lru_cache
from typing import Any, NamedTuple

import msgpack
import numpy as np

UPGRADE = (
    "GET /api/radars/0/feed?{query} HTTP/1.1\r\nhost: {host}\r\nconnection: upgrade\r\nupgrade: websocket\r\n"
    "sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)
MOST_CLIENTS = 1000
HEAD = 600  # bytes: a message's fields up to the times of its at most 32 spokes
PING, PONG = 9, 10
NOTHING = msgpack.packb({"type": "none"})
BUFFER = memoryview(bytearray(1 << 20))
LARGE = 1 << 16  # bytes: so many of no interest are left to the kernel to throw away, as if a network card had taken them
SETTLING = 2.0  # s
CATCH_UP = 10.0  # s that stalled clients are given to read what was kept for them


class Message(NamedTuple):
    """What a message says before its samples. time: of its last spoke [s of simulation]."""

    type: str = ""
    first: int = 0
    count: int = 0
    time: float = 0.0


@lru_cache(maxsize=4096)  # all clients get the same bytes
def parsed(head: bytes) -> Message:
    """The message that begins with these bytes."""
    read = msgpack.Unpacker()
    read.feed(head)
    message: dict[str, Any] = {}
    for _ in range(read.read_map_header()):
        key = read.unpack()
        message[key] = read.unpack()
        if key == "type" and message[key] not in ("spokes", "gap"):
            return Message(message[key])
        if key == ("time" if message.get("type") == "spokes" else "count"):
            break
    return Message(message["type"], message["first"], message["count"], message.get("time", [0.0])[-1])


class Listener:
    """One connection: the heads of its messages are read and checked, their samples passed over."""

    def __init__(self, address: tuple[str, int], query: str) -> None:
        self.socket = connected(address, query)
        self.next, self.spokes, self.lost, self.holes, self.gaps, self.bytes = -1, 0, 0, 0, 0, 0
        self._held = bytearray()
        self._over = 0  # bytes of the running message that are of no interest

    def read(self) -> list[float]:
        """Simulated time of the last spoke of each message that has come."""
        passing_over = self._over >= LARGE
        try:
            if passing_over:
                size = self.socket.recv_into(BUFFER, min(self._over, len(BUFFER)), socket.MSG_TRUNC)
            else:
                size = self.socket.recv_into(BUFFER, LARGE)
        except BlockingIOError:
            return []
        if not size:
            raise ConnectionError("the service closed a connection")
        self.bytes += size
        if passing_over:
            self._over -= size
            return []
        at, got = 0, list[float]()
        while at < size:
            passed = min(self._over, size - at)
            at, self._over = at + passed, self._over - passed
            taken = min(HEAD - len(self._held), size - at)
            self._held += BUFFER[at : at + taken]
            at += taken
            while not self._over and (head := self._head()):
                got += self._counted(parsed(head))
        return got

    def _head(self) -> bytes:
        """The first bytes of the next message, once there are enough; the rest of it will be passed over."""
        if len(self._held) < 2 or len(self._held) < 10 and self._held[1] > 125:
            return b""
        size, at = self._held[1], 2
        if size == 126:
            size, at = struct.unpack_from(">H", self._held, 2)[0], 4
        elif size == 127:
            size, at = struct.unpack_from(">Q", self._held, 2)[0], 10
        if len(self._held) < min(HEAD, at + size):
            return b""
        head = bytes(self._held[at : at + size])
        if self._held[0] & 0x0F == PING:
            self.socket.send(bytes([0x80 | PONG, 0x80 | size]) + b"\0\0\0\0" + head)
            head = NOTHING
        self._over = max(0, at + size - len(self._held))
        del self._held[: at + size]
        return head

    def _counted(self, message: Message) -> list[float]:
        if message.type not in ("spokes", "gap"):
            return []
        self.holes += self.next not in (-1, message.first)
        self.next = message.first + message.count
        if message.type == "gap":
            self.lost += message.count
            self.gaps += 1
            return []
        self.spokes += message.count
        return [message.time]


def connected(address: tuple[str, int], query: str) -> socket.socket:
    """A connection on which the feed begins with the next byte. Raises ConnectionError where it is refused."""
    connection, answer = socket.create_connection(address), bytearray()
    connection.sendall(UPGRADE.format(query=query, host=address[0]).encode())
    while b"\r\n\r\n" not in answer:
        answer += connection.recv(1)
    if not answer.startswith(b"HTTP/1.1 101"):
        raise ConnectionError(bytes(answer).decode(errors="replace"))
    connection.setblocking(False)
    return connection


def followed(listeners: list[Listener], seconds: float) -> tuple[list[float], float]:
    """Read what comes for so long [s]; wall clock less simulated time [s] of each message, and the newest such time."""
    poll, late, newest = selectors.DefaultSelector(), list[float](), 0.0
    for listener in listeners:
        poll.register(listener.socket, selectors.EVENT_READ, listener)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for key, _ in poll.select(0.1):
            for simulated in key.data.read():
                late.append(time.monotonic() - simulated)
                newest = max(newest, simulated)
    return late, newest


def woken(listeners: list[Listener], now: float) -> list[int]:
    """Read what was kept for each; bytes that came before the first spoke younger than what others had by `now`."""
    stale = []
    end = time.monotonic() + CATCH_UP
    for listener in listeners:
        before, newest = listener.bytes, -1.0
        while newest < now and time.monotonic() < end:
            before = listener.bytes
            newest = max([newest, *listener.read()])
        stale.append(before)
    return stale


def main(host: str, port: int, clients: int, seconds: float, stalled: int, query: str) -> dict[str, Any]:
    """Listen that long [s] with so many clients, some of which never read."""
    assert host == "127.0.0.1" and clients <= MOST_CLIENTS, "loopback only, and bounded"
    stalled_listeners = [Listener((host, port), query) for _ in range(stalled)]
    listeners = [Listener((host, port), query) for _ in range(clients - stalled)]
    followed(listeners, SETTLING)
    begun = time.process_time()
    late, newest = followed(listeners, seconds)
    own_cores = round((time.process_time() - begun) / seconds, 2)
    late_ms = 1000 * (np.array(late) - min(late))
    result = {
        "clients": clients, "stalled": stalled, "seconds": seconds, "messages": len(late),
        "spokes_each": min(listener.spokes for listener in listeners), "lost": sum(listener.lost for listener in listeners),
        "holes": sum(listener.holes for listener in listeners), "p50_ms": round(float(np.percentile(late_ms, 50)), 2),
        "p99_ms": round(float(np.percentile(late_ms, 99)), 2), "max_ms": round(float(late_ms.max()), 2),
        "own_cores": own_cores,
    }  # fmt: skip
    if stalled_listeners:
        result["stale_bytes"] = max(woken(stalled_listeners, newest))
        result["stalled_lost"] = min(listener.lost for listener in stalled_listeners)
        result["stalled_holes"] = sum(listener.holes for listener in stalled_listeners)
    for listener in [*listeners, *stalled_listeners]:
        listener.socket.close()
    return result


if __name__ == "__main__":
    host, port, clients, seconds, stalled, query = sys.argv[1:]
    print(json.dumps(main(host, int(port), int(clients), float(seconds), int(stalled), query)))
