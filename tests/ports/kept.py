"""A sender that keeps what it gets."""

from collections.abc import Sequence


class Kept:
    """pieces: all, in order; closed: whether it was."""

    def __init__(self) -> None:
        self.pieces: list[bytes] = []
        self.lost, self.closed = 0, False

    def send(self, pieces: Sequence[bytes]) -> None:
        self.pieces += pieces

    def close(self) -> None:
        self.closed = True
