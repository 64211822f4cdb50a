"""Messages of the native feed as docs/feed.md has them, taken apart into what does not depend on when it was sent.

How spokes are put into messages depends on the machine, so each spoke is compared by itself: by its number and all that its
message says of it.
"""

import zlib
from typing import Any

import msgpack

from tests.measurements.tree_side.kept import lasting

PER_SPOKE = ("time", "azimuth", "heading", "course", "position", "speed", "blind")
TRUTHS = 16  # of those that come, as they follow their spokes when they are computed: two scans


class Messages:
    """What one client has received.

    spokes: by number; others: hellos, gaps and the bye, in order; truths: in order; next: the number after the newest spoke.
    """

    def __init__(self) -> None:
        self.spokes: dict[int, Any] = {}
        self.others: list[dict[str, Any]] = []
        self.truths: list[dict[str, Any]] = []
        self.next = 0

    def take(self, data: bytes) -> None:
        """Takes one message."""
        message = lasting(msgpack.unpackb(data))
        kind = message["type"]
        if kind == "hello":
            message["plan"].pop(
                "counts"
            )  # measured beside the first spokes: a hello has them or not, as busy as the machine is
        if kind == "spokes":
            self._take_spokes(message)
        elif kind in ("truth", "no_truth"):
            self.truths.append(message)
        else:
            self.others.append(message)

    def _take_spokes(self, message: dict[str, Any]) -> None:
        first, count = message.pop("first"), message.pop("count")
        rows = message.pop("row_first", list(range(count)))
        message.pop("row_count", None)
        index = message.pop("index")
        compressed = message.pop("compression", "none") == "deflate"
        cut = {key: _cut(message.pop(key), len(rows), compressed) for key in ("data", "labels", "powers") if key in message}
        each = {key: message.pop(key) for key in PER_SPOKE if key in message}
        for at, row in enumerate(rows):
            own = {key: values if values is None else values[at] for key, values in each.items()}
            parts = {key: pieces[at] for key, pieces in cut.items()}
            self.spokes[first + row] = {**message, **own, **parts, "index": index + row}
        self.next = first + count

    def packed(self) -> dict[str, bytes]:
        """All of it by name."""
        told = {f"spoke-{number:05}": spoke for number, spoke in self.spokes.items()}
        told |= {f"message-{at:03}": message for at, message in enumerate(self.others)}
        told |= {f"truth-{at:03}": message for at, message in enumerate(self.truths[:TRUTHS])}
        return {name: msgpack.packb(message) for name, message in told.items()}


def _cut(data: bytes, rows: int, compressed: bool) -> list[bytes]:
    """The bytes of each row."""
    whole = zlib.decompress(data) if compressed else data
    size = len(whole) // max(rows, 1)
    assert size * rows == len(whole), f"{len(whole)} bytes are not {rows} rows"
    return [whole[row * size : (row + 1) * size] for row in range(rows)]
