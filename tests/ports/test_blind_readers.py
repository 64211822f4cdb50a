"""A reader of a server without --truth learns from no route what the scene does; the holder of the token to command does."""

import json
from dataclasses import replace
from typing import Any

import pytest

from radar_service.ports.rest import pictures
from radar_service.scene_file.load import load_scene
from radar_service.service.access import Access
from radar_service.service.radio.station import Station
from radar_service.service.spokes import Epoch
from tests.ports.playing import playing
from tests.ports.playing import station as paused
from tests.service.fake import FakeEngine, scene

READ, COMMAND = "r" * 16, "c" * 16
READER, COMMANDER = {"authorization": f"Bearer {READ}"}, {"authorization": f"Bearer {COMMAND}"}
HIDDEN = ("own-ship", "bodies/secret", "bodies/nobody", "errors")
SECRETS = ("secret", "123.456789", "6.543211")  # a name, a course, the error of the gyro
CHOICES: list[dict[str, Any]] = [{"what": "range", "modelled": True, "how": "exact"},
                                 {"what": "body secret", "modelled": True, "how": "declared"}]  # fmt: skip


PLAN = {
    "choices": CHOICES, "caveats": ["the mean power of body secret errs"], "counts": {"moving_echoes": 1}, "fidelity": "fast",
    "settings": {},
}  # fmt: skip


def station(truth: bool) -> Station:
    body = {"name": "secret", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 100, 5], "steerable": {}}
    other = load_scene({"own_ship": {"steerable": {}}, "body": [body], "errors": {"gyro": {"bias_deg": 6.543211}}})
    told = replace(
        scene(), world=other.world, platform=other.platform, errors=other.errors, warnings=("body[0]: secret is odd",)
    )
    engine = FakeEngine(told)
    engine.plan = PLAN
    return paused(engine, allow_truth=truth)


def texts(value: object) -> str:
    return json.dumps(value, default=str)


@pytest.mark.parametrize("access", [Access(), Access(COMMAND), Access(COMMAND, READ)], ids=["open", "command", "read"])
async def test_no_get_tells_a_reader_what_the_scene_does(access: Access) -> None:
    async with playing(station(False), access=access) as server:
        command = {"course_deg": 123.456789}
        for path in ("own-ship", "bodies/secret"):
            assert (await server.http.patch(f"/api/radars/0/{path}", json=command, headers=COMMANDER)).status_code == 200
        for path in HIDDEN:
            answer = await server.http.get(f"/api/radars/0/{path}", headers=READER)
            assert answer.status_code == 403 and "--truth" in answer.json()["detail"][0], answer.text
        routes = [path.format(radar="0", name="secret", job="x")
                  for path, methods in server.app.openapi()["paths"].items() if "get" in methods]  # fmt: skip
        assert len(routes) > 10
        for path in [*routes, "/metrics"]:
            answer = await server.http.get(path, headers=READER)
            assert not any(secret in answer.text.replace(path, "") for secret in SECRETS if "bodies" not in path), (
                path,
                answer.text,
            )
        feed = await server.feed(**READER)
        hello = texts(await feed.until("hello"))
        assert not any(secret in hello for secret in SECRETS)


async def test_a_blind_server_tells_the_name_of_its_scene_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Epoch, "is_blind", True)
    monkeypatch.setattr(pictures, "call_in_process", lambda _, job, draw, *arguments: b"drawn" + repr(arguments).encode())
    async with playing(paused(replace(scene(), world=replace(scene().world, name="unmistakable")))) as server:
        changes = await server.open("/api/changes")
        while "epoch" not in (change := await changes.text()):
            pass
        routes = [path.format(radar="0", name="x", job="x")
                  for path, methods in server.app.openapi()["paths"].items() if "get" in methods]  # fmt: skip
        told = [(await server.http.get(path)).text for path in [*routes, "/metrics"]]
        told += [change, texts(await (await server.feed()).until("hello"))]
        assert [text for text in told if "unmistakable" in text] == [] and any("drawn" in text for text in told)


@pytest.mark.parametrize(("truth", "headers"), [(True, READER), (True, COMMANDER), (False, COMMANDER)])
async def test_who_may_know_is_told(truth: bool, headers: dict[str, str]) -> None:
    async with playing(station(truth), access=Access(COMMAND, READ)) as server:
        for path, status in zip(HIDDEN, (200, 200, 404, 200), strict=True):
            assert (await server.http.get(f"/api/radars/0/{path}", headers=headers)).status_code == status
        radar = (await server.http.get("/api/radars/0", headers=headers)).json()
        told = [radar, await (await server.feed(**headers)).until("hello")] if truth else [radar]
        for each in told:
            assert each["plan"]["choices"] == CHOICES and each["scene"]["warnings"] == ["body[0]: secret is odd"]
