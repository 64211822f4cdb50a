"""The newest messages of one view, so that a client that reconnects misses nothing."""

from collections import deque

from radar_service.stream.codecs.codec import Codec
from radar_service.stream.fanout.client_queue import QueueItem, gap

HISTORY_BYTES = 4 * 2**20  # per view: 14 s of 1 KiB spokes at 24 rpm and 720 azimuths


class ViewHistory:
    """The newest messages of the running epoch in one view, at most HISTORY_BYTES of them.

    idle_since: time when the last client of the view left [s of the hub's clock], None while there is one.
    """

    def __init__(self, codec: Codec) -> None:
        self.idle_since: float | None = None
        self._codec = codec
        self._items: deque[QueueItem] = deque()
        self._size = 0

    def add(self, item: QueueItem) -> None:
        """Keeps a message and drops the oldest ones beyond the bound."""
        self._items.append(item)
        self._size += len(item.data)
        while self._size > HISTORY_BYTES and len(self._items) > 1:
            self._size -= len(self._items.popleft().data)

    def clear(self) -> None:
        """Drops all messages."""
        self._items.clear()
        self._size = 0

    def since(self, epoch: str, first: int, end: int) -> list[QueueItem]:
        """Returns the messages that cover the sequence numbers from `first` to `end`, with a gap for those not kept."""
        kept = [item for item in self._items if item.first + item.count > first]
        start = kept[0].first if kept else end
        if start > first:
            return [gap(self._codec, epoch, first, start - first, "no longer held"), *kept]
        if kept and start < first:
            kept[0] = self._rest(kept[0], epoch, first)
        return kept

    def _rest(self, item: QueueItem, epoch: str, first: int) -> QueueItem:
        """Returns the part of a message from the number `first` on."""
        count = item.first + item.count - first
        if not item.droppable:
            return gap(self._codec, epoch, first, count, "the radar did not send them")
        return QueueItem(self._codec.trim(item.data, count), epoch, first, count, True)
