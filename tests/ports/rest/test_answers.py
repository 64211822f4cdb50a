"""Refusals as answers: a line for each problem."""

import errno

import pytest
from fastapi import FastAPI

from radar_service.plug_ins import PlugInError
from radar_service.ports.rest.answers import add_exception_handlers, problem_lines
from radar_service.ports.rest.scene_store import Conflict
from radar_service.processes.limits import MachineBusyError
from radar_service.service.controls import ControlError
from radar_service.service.jobs import RETRY_SECONDS, Busy
from radar_service.service.radio.prefetch import BusyFault, SpokeSourceFault
from radar_service.world.error import SceneError
from tests.ports.playing import playing


@pytest.mark.parametrize(
    ("error", "status", "lines"),
    [
        (SceneError("a: bad", "b: bad"), 422, ["a: bad", "b: bad"]), (ControlError("gain: 140"), 422, ["gain: 140"]),
        (SpokeSourceFault("it broke"), 422, ["scene: it broke"]), (PlugInError("it is broken"), 422, ["scene: it is broken"]),
        (Conflict("it is full"), 409, ["it is full"]),
    ],
)  # fmt: skip
async def test_each_error_has_its_status_and_its_lines(error: Exception, status: int, lines: list[str]) -> None:
    async with playing() as server:

        async def fail() -> None:
            raise error

        server.app.router.add_api_route("/api/fails", fail)
        server.app.router.routes.insert(0, server.app.router.routes.pop())  # before the page, which answers all the rest
        answer = await server.http.get("/api/fails")
        assert (answer.status_code, answer.json()) == (status, {"detail": lines})


BUSY_ERRORS = [OSError(errno.EMFILE, "x"), OSError(errno.ENFILE, "x"), MachineBusyError("x"), BusyFault("x"), Busy("x")]


@pytest.mark.parametrize("error", BUSY_ERRORS, ids=repr)
async def test_what_is_to_be_tried_again_says_when(error: Exception) -> None:
    async with playing() as server:

        async def fail() -> None:
            raise error

        server.app.router.add_api_route("/api/fails", fail)
        server.app.router.routes.insert(0, server.app.router.routes.pop())
        answer = await server.http.get("/api/fails")
        assert answer.status_code == 503 and answer.headers["retry-after"] == str(RETRY_SECONDS)
        if isinstance(error, OSError):
            assert answer.json()["detail"][0].startswith("request: the server has no file descriptors left; ")


def test_lines_name_the_key_the_value_and_the_problem() -> None:
    errors = [
        {"loc": ("body", "pace", "factor"), "input": 0, "msg": "too small"},
        {"loc": ("query",), "input": "x" * 100, "msg": "too long"},
    ]
    assert problem_lines(errors) == ["pace.factor: 0; too small", "body: too long"]
    assert len(problem_lines([errors[0]] * 30)) == 20


def test_handlers_are_added_to_any_application() -> None:
    app = FastAPI()
    add_exception_handlers(app)
    assert {SceneError, ControlError, SpokeSourceFault, Conflict} <= set(app.exception_handlers)
