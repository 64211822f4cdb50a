"""The request of one client of a feed, independent of the protocol."""

from dataclasses import dataclass
from typing import Literal

Mode = Literal["live", "lossless"]


@dataclass(frozen=True)
class View:
    """What a client receives. Clients with equal views share their bytes, so a view is encoded once.

    encoding: of the samples, one of the codec's.
    bins: per spoke; None is one for each range cell.
    sector: true bearings [degrees] from and to, clockwise; None for all.
    spokes: at most this many neighbouring azimuths become one row by their peaks.
    compression: of the samples; "" for none.
    codec: name of the protocol in `codecs.registry`.
    """

    encoding: str
    bins: int | None = None
    sector: tuple[int, int] | None = None
    spokes: int = 1
    compression: str = ""
    codec: str = "native"

    def as_dict(self) -> dict[str, object]:
        """Returns what the view filters, merges and compresses, as plain data."""
        return {"sector_deg": self.sector and list(self.sector), "spokes": self.spokes, "compression": self.compression}


@dataclass(frozen=True)
class FeedRequest:
    """The request of one client. since: epoch, and sequence number of the first spoke that the client does not have."""

    view: View = View("u8")
    mode: Mode = "live"
    truth: bool = False
    since: tuple[str, int] | None = None
