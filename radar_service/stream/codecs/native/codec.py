"""The native feed as a codec: msgpack maps, see `wire` for their fields."""

from collections.abc import Mapping

from radar_service.records import Truth
from radar_service.stream.codecs.native import messages, wire
from radar_service.stream.codecs.native.request import request_from_query
from radar_service.stream.codecs.native.views import apply_view, trim
from radar_service.stream.feed_request import FeedRequest, Mode, View
from radar_service.stream.spokes import RadarInfo, SpokeBatch


class NativeCodec:
    """Packs the messages of the native feed."""

    name = "native"
    path = "/api/radars/{radar}/feed"

    def request(self, query: Mapping[str, str], is_local: bool) -> FeedRequest:
        """Returns the request of a query string. Raises ValueError that names the parameter."""
        return request_from_query(query, is_local)

    def hello(self, radar: RadarInfo, view: View, mode: Mode) -> bytes:
        """Returns the hello of an epoch."""
        return wire.pack(messages.hello(radar, view, mode))

    def spokes(self, batch: SpokeBatch, view: View) -> bytes:
        """Returns the spokes in the view's encoding, filtered, merged and compressed as the view requests."""
        return wire.pack(apply_view(messages.spokes(batch, view), view))

    def truth(self, epoch: str, state: Truth) -> bytes:
        """Returns the true state."""
        return wire.pack(messages.truth(epoch, state))

    def no_truth(self, epoch: str, time: float, until: float, count: int, reason: str) -> bytes:
        """Returns the announcement of truths that will not come."""
        fields = {"time": time, "until": until, "count": count, "reason": reason}
        return wire.pack({"type": "no_truth", "epoch": epoch, **fields})

    def gap(self, epoch: str, first: int, count: int, reason: str) -> bytes:
        """Returns the announcement of lost spokes."""
        return wire.pack({"type": "gap", "epoch": epoch, "first": first, "count": count, "reason": reason})

    def bye(self, epoch: str, reason: str) -> bytes:
        """Returns the last message."""
        return wire.pack({"type": "bye", "epoch": epoch, "reason": reason})

    def trim(self, data: bytes, count: int) -> bytes:
        """Returns a message of spokes cut down to its last `count` spokes."""
        return wire.pack(trim(wire.unpack(data), count))
