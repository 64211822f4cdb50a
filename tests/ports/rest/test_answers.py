"""Refusals as answers: a line for each problem."""

import errno

from fastapi import FastAPI

from radar_service.plug_ins import PlugInError
from radar_service.ports.rest.answers import add_exception_handlers, problem_lines
from radar_service.ports.rest.scene_store import Conflict
from radar_service.processes.limits import MachineBusyError
from radar_service.service.controls import ControlError
from radar_service.service.jobs import RETRY_SECONDS, Busy
from radar_service.service.radio.prefetch import BusyFault, SpokeSourceFault
from radar_service.world.error import SceneError
from tests.ports.asgi import running


def failing(*errors: Exception) -> FastAPI:
    """An application whose path /N raises error N."""
    app = FastAPI()
    add_exception_handlers(app)

    @app.get("/{number}")
    async def fail(number: int) -> None:
        raise errors[number]

    return app


async def test_each_error_has_its_status_and_its_lines() -> None:
    cases: list[tuple[Exception, int, list[str]]] = [
        (SceneError("a: bad", "b: bad"), 422, ["a: bad", "b: bad"]), (ControlError("gain: 140"), 422, ["gain: 140"]),
        (SpokeSourceFault("it broke"), 422, ["scene: it broke"]), (PlugInError("it is broken"), 422, ["scene: it is broken"]),
        (Conflict("it is full"), 409, ["it is full"]),
    ]  # fmt: skip
    async with running(failing(*(error for error, _, _ in cases))) as server:
        for number, (_, status, lines) in enumerate(cases):
            answer = await server.http.get(f"/{number}")
            assert (answer.status_code, answer.json()) == (status, {"detail": lines})


async def test_what_is_to_be_tried_again_says_when() -> None:
    full = OSError(errno.EMFILE, "x"), OSError(errno.ENFILE, "x")
    errors = [*full, MachineBusyError("x"), BusyFault("x"), Busy("x")]
    async with running(failing(*errors)) as server:
        for number, error in enumerate(errors):
            answer = await server.http.get(f"/{number}")
            assert answer.status_code == 503 and answer.headers["retry-after"] == str(RETRY_SECONDS), error
            if error in full:
                assert answer.json()["detail"][0].startswith("request: the server has no file descriptors left; ")


def test_lines_name_the_key_the_value_and_the_problem() -> None:
    errors = [
        {"loc": ("body", "pace", "factor"), "input": 0, "msg": "too small"},
        {"loc": ("query",), "input": "x" * 100, "msg": "too long"},
    ]
    assert problem_lines(errors) == ["pace.factor: 0; too small", "body: too long"]
    assert len(problem_lines([errors[0]] * 30)) == 20
