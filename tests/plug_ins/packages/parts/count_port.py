"""A port that sends the numbers of spokes by UDP, of a recording too."""

import argparse
import json
import socket
from collections.abc import Mapping, Sequence
from typing import Any

from radar_service.ports.port import Port
from radar_service.service.spokes import SpokeBatch

replays = True


def add_arguments(groups: Mapping[str, Any]) -> None:
    groups["where"].add_argument("--count", type=int, metavar="PORT", help="send numbers of spokes to this UDP port")


def opened(options: argparse.Namespace) -> "CountPort | None":
    return None if options.count is None else CountPort(options.count)


class CountPort(Port):
    name = "count"

    def __init__(self, port: int) -> None:
        self._to, self._socket = ("127.0.0.1", port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def sinks(self, radar: str) -> Sequence[Any]:
        return (self,)

    def open_epoch(self, radar: Any) -> None: ...

    def send(self, batch: SpokeBatch) -> None:
        video = batch.video_bytes(batch.epoch.layout(None))
        message = {"first": batch.first, "count": len(batch), "shape": video.shape}
        self._socket.sendto(json.dumps(message).encode(), self._to)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None: ...

    def close(self, reason: str = "") -> None: ...
