"""The request of one client of a feed, independent of the protocol."""

from dataclasses import dataclass
from typing import Any, Literal

from radar_service.records import PowersOf, SourceRequest

Mode = Literal["live", "lossless"]


@dataclass(frozen=True)
class View:
    """What a client receives. Clients with equal views share their bytes, so a view is encoded once.

    encoding: of the samples, one of the codec's.
    bins: per spoke; None is one for each range cell.
    sector: true bearings [degrees] from and to, clockwise; None for all.
    spokes: at most this many neighbouring azimuths become one row by their peaks.
    compression: of the samples; "" for none.
    labels: whether spokes name the strongest source of each bin. powers: of which sources they have the power in each bin.
    codec: name of the protocol in `codecs.codec`.
    """

    encoding: str
    bins: int | None = None
    sector: tuple[int, int] | None = None
    spokes: int = 1
    compression: str = ""
    codec: str = "native"
    labels: bool = False
    powers: PowersOf = ()

    @property
    def is_whole(self) -> bool:
        """Whether each spoke is a row of its own."""
        return self.sector is None and self.spokes == 1

    @property
    def sources(self) -> SourceRequest:
        """What the spokes tell of their sources."""
        return SourceRequest(self.labels, self.powers)

    def as_dict(self) -> dict[str, Any]:
        """Returns what the view filters, merges, compresses and adds, as plain data."""
        changed = {"sector_deg": self.sector and list(self.sector), "spokes": self.spokes, "compression": self.compression}
        powers = self.powers if self.powers == "all" else list(self.powers)
        return changed | ({"labels": self.labels, "powers": powers} if self.sources else {})


@dataclass(frozen=True)
class FeedRequest:
    """The request of one client. since: epoch, and sequence number of the first spoke that the client does not have."""

    view: View = View("u8")
    mode: Mode = "live"
    truth: bool = False
    since: tuple[str, int] | None = None
