"""A port as others may write one: text by websocket in both directions, UDP out, and a clock. A class and two functions."""

import argparse
import json
import socket
from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import APIRouter
from starlette.websockets import WebSocket

from radar_service.ports.port import Port, Service
from radar_service.ports.rest.schemas import ControlsChange
from radar_service.ports.roles import needs
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink
from radar_service.terminal.arguments import UsageError


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    groups["where"].add_argument("--toy", type=int, metavar="PORT", help="send numbers of spokes to this UDP port")


def opened(options: argparse.Namespace) -> "ToyPort | None":
    if options.toy is None:
        return None
    if not 0 < options.toy < 65536:
        raise UsageError(f"--toy: {options.toy} is not a port; give one from 1 to 65535")
    return ToyPort(options.toy)


class ToySink:
    def __init__(self, radar: str, port: "ToyPort") -> None:
        self._radar, self._port = radar, port

    def open_epoch(self, radar: RadarInfo) -> None:
        self._port.say({"radar": self._radar, "opened": radar.epoch.info.scene.name})

    def send(self, batch: SpokeBatch) -> None:
        self._port.say({"radar": self._radar, "first": batch.first, "count": len(batch)})

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        self._port.say({"radar": self._radar, "skipped": [first, count], "reason": reason})

    def close(self, reason: str) -> None:
        self._port.say({"radar": self._radar, "closed": reason})


class ToyPort(Port):
    """Numbers of spokes, changes and times by UDP; controls by websocket, which answers with their state."""

    name, period = "toy", 0.05

    def __init__(self, port: int) -> None:
        self._address = "127.0.0.1", port
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def routes(self, service: Service) -> Sequence[APIRouter]:
        router = APIRouter()

        @router.websocket("/toy/{radar}")
        @needs("command")
        async def converse(socket: WebSocket, radar: str) -> None:
            await socket.accept()
            station = service.stations[radar]
            async for text in socket.iter_text():
                try:
                    await station.change(ControlsChange.model_validate_json(text).model_dump(exclude_none=True))
                except ValueError as error:
                    await socket.send_text(f"refused: {error}")
                else:
                    await socket.send_text(json.dumps(station.controls()["gain"]))

        @router.get("/toy")
        @needs("read")
        async def radars() -> list[str]:
            return list(service.stations)

        return (router,)

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        return (ToySink(radar, self),)

    def tick(self, radar: str, time: float) -> None:
        self.say({"radar": radar, "time": time})

    def changed(self, change: StateChange) -> None:
        self.say({"radar": change.radar, "changed": change.kind, "values": dict(change.values)})

    def say(self, words: dict[str, Any]) -> None:
        self._socket.sendto(json.dumps(words).encode(), self._address)

    def close(self) -> None:
        self._socket.close()
