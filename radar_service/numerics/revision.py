"""Counts how often something has changed that kept results depend on besides their keys: the motions under command."""


class Revision:
    """The number of a state that changes. Whoever changes it says so by `change`; who keeps results compares the number."""

    def __init__(self) -> None:
        self.number = 0

    def change(self) -> None:
        """Notes that the state has changed. Nothing that depends on it may be computed meanwhile."""
        self.number += 1


STEADY = Revision()  # of what never changes
