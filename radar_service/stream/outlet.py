"""Where the transmitter's spokes go, and the stretches that they come in."""

import secrets
from dataclasses import dataclass
from typing import Protocol

from radar_service.display.video import Layout
from radar_service.stream import messages
from radar_service.stream.hub import Batch
from radar_service.stream.mailbox import View
from radar_service.stream.messages import Engine


@dataclass(frozen=True)
class Epoch:
    """A stretch of the feed over which sequence numbers count and the cells stay the same."""

    name: str
    engine: Engine
    range: float | None

    def layout(self, bins: int | None) -> Layout:
        """How a spoke of this epoch becomes that many bins."""
        return messages.engine_layout(self.engine, bins, self.range)


class Outlet(Protocol):
    """Where spokes go. Called from the transmitter's thread; each call returns when it has been heeded."""

    def open_epoch(self, epoch: Epoch) -> None:
        """Another epoch begins; numbers start at 0."""

    def views(self) -> tuple[View, ...]:
        """What to encode."""

    def wants_truth(self) -> bool:
        """Whether anybody listens to the truth."""

    def publish(self, batch: Batch) -> None:
        """The next spokes."""

    def missed(self, epoch: str, count: int, reason: str) -> None:
        """The next spokes of this epoch will never come."""

    def restarting(self, reason: str) -> None:
        """The engine has died, and another one is being made."""

    def died(self, reason: str) -> None:
        """No more spokes come until another epoch begins."""


def new_epoch_name() -> str:
    """A name that no other epoch has had, in this process or an earlier one."""
    return secrets.token_hex(4)
