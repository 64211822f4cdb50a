"""A service that sends a picture known beforehand: the page, the REST side and the feed of a radar that stands still."""

import asyncio
import contextlib
import socket
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import numpy as np
import uvicorn
from fastapi import FastAPI, Request, Response, WebSocket, WebSocketDisconnect
from fastapi.responses import JSONResponse
from fastapi.staticfiles import StaticFiles
from numpy.typing import NDArray
from starlette.datastructures import UploadFile

from radar_service import wire
from radar_service.service.controls import control_definitions
from tests.service.fake import scene as fake_scene

WEB = Path(__file__).parents[2] / "clients" / "web"
POLICY = "default-src 'self'"


class Picture:
    """A u8 picture of `azimuths` spokes with spots of full strength and, if asked for, a full ring in its last cells.

    By default it reaches to 1.5 NM, a standard range scale.
    """

    def __init__(self, azimuths: int = 720, bins: int = 512, step: float = 2778 / 512, rim: bool = True) -> None:
        self.azimuths, self.bins, self.step = azimuths, bins, step
        self.video: NDArray[np.uint8] = np.zeros((azimuths, bins), dtype=np.uint8)
        if rim:
            self.video[:, -max(1, bins // 60) :] = 255  # two pixels and more of the smallest screen

    @property
    def range(self) -> float:
        """Far edge of the last cell [m]."""
        return self.bins * self.step

    def spot(
        self, bearing_deg: float, distance: float, halfwidth_deg: float = 2.0, cells: int = 5, level: int = 255
    ) -> None:
        """An echo centred on the azimuth and the cell nearest to a place [m]."""
        row = round(bearing_deg / 360 * self.azimuths)
        half = round(halfwidth_deg / 360 * self.azimuths)
        cell = int(distance / self.step)
        rows = np.arange(row - half, row + half + 1) % self.azimuths
        self.video[rows, cell - cells // 2 : cell + cells // 2 + 1] = level


class FakeRadar:
    """Serves `picture` at `heading_deg` to every client that connects, one whole scan; more can be sent by hand."""

    def __init__(self) -> None:
        self.picture = Picture()
        self.heading_deg = 0.0
        self.range_max: float | None = None  # m; None: of the picture
        self.epoch = "one"
        self.radars = [{"id": "0", "name": "test radar"}]
        self.scenes = [{"name": "known", "title": "known", "summary": "3 bodies"}, {"name": "other", "title": "other"}]
        self.scene = "known"
        self.stream: list[float] | None = None
        self.origin: dict[str, float] | None = None
        self.gives_truth = False
        self.fidelity = "balanced"
        self.errors: dict[str, Any] = {}
        self.asked_for_errors = 0
        self.health: dict[str, Any] = {"id": "0", "state": "running", "factor_reached": 1.0}
        self.uploads: list[tuple[str, list[tuple[str, str, bytes]]]] = []  # name, and field, name and content of files
        self.removed: list[str] = []
        self.warnings: list[str] = []
        self.blind_sectors_deg: list[list[float]] = []
        pace = {"state": "run", "factor": 1.0}
        self.controls: dict[str, Any] = {
            "transmit": True, "range_m": None, "gain": 50, "sea": 0, "rain": 0, "rpm": 24.0, "pace": pace,
        }  # fmt: skip
        self.patched: list[dict[str, Any]] = []
        self.joined: list[dict[str, str]] = []  # the query of each connection
        self.next = 0
        self.sockets: list[WebSocket] = []
        self.followers: list[WebSocket] = []  # of changes
        self.followed = threading.Event()  # by one
        self._loop: asyncio.AbstractEventLoop | None = None

    def hello(self) -> dict[str, Any]:
        """The first message."""
        picture = self.picture
        radar = {"id": "0", "name": "test radar", "azimuths": picture.azimuths, "rpm": 24.0, "bins": picture.bins}
        radar |= {
            "height_m": 0.0,
            "modulation": "none",
            "bandwidth_hz": 20e6,
            "pulse_s": 80e-9,
            "prf_hz": 2100.0,
            "power_w": 25e3,
            "range_step_m": picture.step,
            "range_max_m": self.range_max or picture.range,
            "blind_sectors_deg": self.blind_sectors_deg,
        }
        encoding = {"name": "u8", "bins": picture.bins, "range_step_m": picture.step, "range_first_m": picture.step / 2}
        encoding |= {"range_m": picture.range, "dtype": "|u1", "db_per_step": 0.5, "offset_db": -140.0}
        return {
            "type": "hello", "protocol": 1, "epoch": self.epoch, "radar": radar, "encoding": encoding,
            "scene": {"name": self.scene, "origin": self.origin, "bodies": 3, "warnings": self.warnings,
                      **({"stream": self.stream} if self.stream else {})},
            "seed": 0, "fidelity": self.fidelity, "arithmetic": "fake", "plan": {}, "controls": self.controls,
            "truth": self.gives_truth,
            "clocks": {"simulated_s": 0.0, "utc": "2026-01-01T00:00:00+00:00", "pace": self.controls["pace"]},
        }  # fmt: skip

    def description(self, identity: str) -> dict[str, Any]:
        """What REST says of the radar, as far as the page reads it."""
        definitions = control_definitions(fake_scene(range_max_m=self.range_max or self.picture.range))
        return {"id": identity, "controls": self.controls, "control_definitions": definitions}

    def spokes(self, first: int, count: int) -> dict[str, Any]:
        """Spokes `first` and on; they must not cross a scan's end."""
        picture = self.picture
        scan, index = divmod(first, picture.azimuths)
        number = first + np.arange(count)
        azimuth = wire.turn_from_radians((number % picture.azimuths) * (2 * np.pi / picture.azimuths))
        turn = wire.turn_from_radians(np.full(count, np.deg2rad(self.heading_deg)))
        return {
            "type": "spokes", "epoch": self.epoch, "first": first, "count": count, "scan": scan, "index": index,
            "time": (number * (2.5 / picture.azimuths)).tolist(), "azimuth": azimuth, "heading": turn, "course": turn,
            "position": [[0.0, 0.0]] * count, "speed": [5.0] * count, "bins": picture.bins, "range_step_m": picture.step,
            "range_first_m": picture.step / 2, "range": picture.range, "encoding": "u8",
            "data": picture.video[index : index + count].tobytes(),
        }  # fmt: skip

    def truth(self, **bodies: dict[str, Any]) -> dict[str, Any]:
        """A truth message: own ship at rest in the origin, and the bodies by name with what differs from one at rest there."""
        plain = {
            "position": [0.0, 0.0, 0.0], "velocity": [0.0, 0.0, 0.0], "heading": 0.0, "course": 0.0, "speed": 0.0,
            "range": 0.0, "azimuth": 0.0, "elevation": 0.0, "visible": True, "reason": "", "latitude_deg": None,
            "longitude_deg": None, "mmsi": None, "extent": 0.0,
        }  # fmt: skip
        listed = [plain | {"name": name} | what for name, what in bodies.items()]
        own = plain | {"name": "own ship"}
        return {"type": "truth", "epoch": self.epoch, "time": 0.0, "own_ship": own, "bodies": listed}

    async def _scan(self, send: Callable[[bytes], Awaitable[None]]) -> None:
        stop = self.next + self.picture.azimuths
        for start in range(self.next, stop, 60):
            await send(wire.pack(self.spokes(start, min(60, stop - start))))

    async def changes(self, client: WebSocket) -> None:
        """One client of the changes."""
        await client.accept()
        self._loop = asyncio.get_running_loop()
        self.followers.append(client)
        self.followed.set()
        with contextlib.suppress(WebSocketDisconnect):
            await client.receive_text()
        self.followers.remove(client)

    async def feed(self, client: WebSocket) -> None:
        """One client."""
        await client.accept()
        self._loop = asyncio.get_running_loop()
        self.joined.append(dict(client.query_params))
        await client.send_bytes(wire.pack(self.hello()))
        self.sockets.append(client)
        await self._scan(client.send_bytes)
        try:
            while True:
                await client.receive_bytes()
        except WebSocketDisconnect:
            if client in self.sockets:
                self.sockets.remove(client)

    def send(self, *messages: dict[str, Any]) -> None:
        """Send messages to every client, from the test's thread."""
        self._run(lambda client: [client.send_bytes(wire.pack(message)) for message in messages])

    def drop(self, code: int = 1012) -> None:
        """Close every connection."""
        self._run(lambda client: [client.close(code)])

    def drop_followers(self) -> None:
        """Close the connections of changes."""
        self._run(lambda client: [client.close(1012)], self.followers)

    def tell(self, kind: str, radar: str = "0", **values: Any) -> None:
        """Tell every client of a change of a radar, from the test's thread; waits for the first client."""
        assert self.followed.wait(60)
        change = {"radar": radar, "kind": kind, "values": values, "time": 0.0}
        self._run(lambda client: [client.send_json(change)], self.followers)

    def _run(self, what: Callable[[WebSocket], list[Awaitable[None]]], sockets: list[WebSocket] | None = None) -> None:
        async def all_of() -> None:
            for client in list(self.sockets if sockets is None else sockets):
                for step in what(client):
                    await step

        assert self._loop is not None
        asyncio.run_coroutine_threadsafe(all_of(), self._loop).result(10)


class Air:
    """What is on the air: a service outlives the radars of the tests that use it."""

    def __init__(self) -> None:
        self.radar = FakeRadar()


def fake_app(air: Air) -> FastAPI:
    """The service around a radar, under the content security policy of the real one."""
    app = FastAPI()

    @app.middleware("http")
    async def policy(request: Request, go_on: Callable[[Request], Awaitable[Response]]) -> Response:
        answer = await go_on(request)
        answer.headers["Content-Security-Policy"] = POLICY
        return answer

    @app.get("/api/radars")
    def radars() -> list[dict[str, Any]]:
        return [air.radar.description(listed["id"]) | listed for listed in air.radar.radars]

    @app.get("/api/radars/{name}")
    def description(name: str) -> dict[str, Any]:
        return air.radar.description(name)

    @app.get("/api/radars/{name}/errors")
    def errors(name: str) -> dict[str, Any]:
        air.radar.asked_for_errors += 1
        return dict.fromkeys(("gyro", "log", "position", "antenna", "feed")) | air.radar.errors

    @app.get("/api/scenes")
    def scenes() -> list[dict[str, str]]:
        return air.radar.scenes

    @app.post("/api/scenes", status_code=201)
    async def upload(request: Request) -> Response:
        async with request.form() as form:
            parts = [(field, part) for field, part in form.multi_items() if isinstance(part, UploadFile)]
            files = [(field, str(part.filename), await part.read()) for field, part in parts]
            name = str(form["name"])
        air.radar.uploads.append((name, files))
        if any(b"bad" in content for _, _, content in files):
            return JSONResponse({"detail": ["body[0]: bad; mend it"]}, 422)
        air.radar.scenes.append({"name": name, "title": "sent", "summary": "1 bodies", "origin": "uploaded"})
        return JSONResponse({"name": name, "bodies": 1, "warnings": []}, 201)

    @app.delete("/api/scenes/{name}", status_code=204)
    async def remove(name: str) -> None:
        air.radar.removed.append(name)
        air.radar.scenes = [scene for scene in air.radar.scenes if scene["name"] != name]

    @app.get("/api/health")
    def health() -> dict[str, Any]:
        return {"radars": [air.radar.health]}

    @app.patch("/api/radars/{name}/controls")
    async def patch(name: str, request: Request) -> Response:
        radar, change = air.radar, await request.json()
        radar.patched.append(dict(change))
        if change.get("rpm") == 13:
            return JSONResponse({"detail": ["rpm: 13 is unlucky; choose another"]}, 422)
        pace = radar.controls["pace"] | change.pop("pace", {})
        radar.controls |= change | {"pace": pace}
        return JSONResponse(radar.controls)

    @app.put("/api/radars/{name}/scene")
    async def scene(name: str, request: Request) -> dict[str, Any]:
        air.radar.scene = (await request.json())["scene"]
        plan = {
            "choices": [
                {"what": "beam", "modelled": True, "how": "sinc2"},
                {"what": "rain", "modelled": False, "how": "no rain"},
            ]
        }
        return {"name": air.radar.scene, "bodies": 1, "warnings": [], "epoch": "two", "plan": plan}

    @app.websocket("/api/radars/{name}/feed")
    async def feed(client: WebSocket) -> None:
        await air.radar.feed(client)

    @app.websocket("/api/changes")
    async def changes(client: WebSocket) -> None:
        await air.radar.changes(client)

    app.mount("/", StaticFiles(directory=WEB, html=True))
    return app


class Served:
    """A service on a free port of loopback, in a thread of its own."""

    def __init__(self, app: FastAPI) -> None:
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._socket.getsockname()[1]}/"
        self._server = uvicorn.Server(
            uvicorn.Config(app, log_level="warning", ws_max_size=65536, timeout_graceful_shutdown=1)
        )
        self._thread = threading.Thread(target=self._server.run, kwargs={"sockets": [self._socket]})
        self._thread.start()

    def close(self) -> None:
        """Stop and wait."""
        self._server.should_exit = True
        self._thread.join(10)
        self._socket.close()
