"""The account of a feed: which spokes came, which were announced as lost, which are simply missing."""


class Ledger:
    """What came and what did not, within the running epoch; `next` is the number expected next, None if any will do."""

    def __init__(self) -> None:
        self.epoch: str | None = None
        self.next: int | None = None
        self.epochs = self.received = self.announced = self.holes = self.repeats = 0

    @property
    def lost(self) -> int:
        """Spokes that were sent by the radar and did not come: announced by `gap`, or simply missing."""
        return self.announced + self.holes

    def hello(self, epoch: str, next: int | None) -> None:
        """A greeting; `next` is where a new epoch must begin (0 where its opening was watched, else None)."""
        if epoch != self.epoch:
            self.epoch, self.next = epoch, next
            self.epochs += 1

    def spokes(self, first: int, count: int) -> int:
        """Note spokes that came; returns how many of them, from the front, had come before."""
        expected = self.next if self.next is not None else first
        self.holes += max(0, first - expected)
        repeated = min(count, max(0, expected - first))
        self.received += count - repeated
        self.repeats += repeated
        self.next = max(expected, first + count)
        return repeated

    def gap(self, first: int, count: int) -> None:
        """Note an announced loss."""
        expected = self.next if self.next is not None else first
        self.holes += max(0, first - expected)
        self.announced += max(0, first + count - max(first, expected))
        self.next = max(expected, first + count)
