"""The interface of protocols: a codec encodes what a radar sends as the messages of one protocol."""

from collections.abc import Mapping
from typing import Protocol

from radar_service.records import Truth
from radar_service.service.codecs.native.messages import NativeCodec
from radar_service.service.feed_request import FeedRequest, Mode, View
from radar_service.service.spokes import RadarInfo, SpokeBatch


class Codec(Protocol):
    """One protocol. Methods return one message as bytes, without I/O and without state, and may run in any thread.

    b"" stands for a message that the protocol does not have: it is not sent. To add a protocol, write a codec and
    name it in `codecs` of its port (`ports.port`); the port `port` serves it at `path`.
    """

    @property
    def name(self) -> str:
        """Name in `CODECS` and in `View.codec`."""

    @property
    def port(self) -> str:
        """Name of the port whose routes serve it."""

    @property
    def rising(self) -> bool:
        """Whether it leaves out spokes whose numbers are not above the last one, as errors on purpose send them."""

    @property
    def path(self) -> str:
        """Address of the websocket feed; `{radar}` stands for the radar's id."""

    def request(self, query: Mapping[str, str], is_local: bool) -> FeedRequest:
        """Returns the request in the query string of a feed's address. Raises ValueError that names the parameter.

        is_local: the client runs on this machine.
        """

    def hello(self, radar: RadarInfo, view: View, mode: Mode) -> bytes:
        """Returns the first message of an epoch."""

    def spokes(self, batch: SpokeBatch, view: View) -> bytes:
        """Returns a batch as a client with this view receives it."""

    def truth(self, epoch: str, state: Truth) -> bytes:
        """Returns the true state of everything."""

    def no_truth(self, epoch: str, time: float, until: float, count: int, reason: str) -> bytes:
        """Returns the announcement of `count` truths, from `time` to `until` [s of simulation], that will not come."""

    def gap(self, epoch: str, first: int, count: int, reason: str) -> bytes:
        """Returns the message that announces lost spokes: `count` of them from sequence number `first` on."""

    def bye(self, epoch: str, reason: str) -> bytes:
        """Returns the last message before the server closes the connection."""

    def trim(self, data: bytes, count: int) -> bytes:
        """Returns a message of `spokes` cut down to its last `count` spokes."""


CODECS: dict[str, Codec] = {NativeCodec.name: NativeCodec()}  # by name; those of ports join when a service begins
