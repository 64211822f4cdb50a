"""Sequence numbers of a feed: which spokes arrived, which were announced as lost, and which are missing."""


class SequenceTracker:
    """Counts spokes over all epochs. `next` is the number expected next in this epoch; None accepts any number.

    epochs: hellos that opened a new epoch.
    received: spokes that arrived, each counted once.
    announced: spokes that a `gap` message reported as lost.
    missing: spokes that were lost without an announcement.
    repeated: spokes that arrived again.
    """

    def __init__(self) -> None:
        self.epoch: str | None = None
        self.next: int | None = None
        self.epochs = self.received = self.announced = self.missing = self.repeated = 0

    @property
    def lost(self) -> int:
        """Spokes that the radar made and that did not arrive, announced or not."""
        return self.announced + self.missing

    def hello(self, epoch: str, next: int | None) -> None:
        """Opens a new epoch at number `next`: 0 if this client saw the epoch begin, else None. The same epoch is ignored."""
        if epoch != self.epoch:
            self.epoch, self.next = epoch, next
            self.epochs += 1

    def spokes(self, first: int, count: int) -> int:
        """Counts spokes that arrived; returns how many of them, from the front, are repeats."""
        expected = self.next if self.next is not None else first
        self.missing += max(0, first - expected)
        repeated = min(count, max(0, expected - first))
        self.received += count - repeated
        self.repeated += repeated
        self.next = max(expected, first + count)
        return repeated

    def gap(self, first: int, count: int) -> None:
        """Counts an announced loss."""
        expected = self.next if self.next is not None else first
        self.missing += max(0, first - expected)
        self.announced += max(0, first + count - max(first, expected))
        self.next = max(expected, first + count)
