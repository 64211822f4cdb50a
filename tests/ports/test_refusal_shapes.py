"""Refusals in the shape of a protocol: below its paths alone, and only what has no shape of its own."""

import asyncio
import json
from typing import Any

import pytest
from starlette.responses import JSONResponse, Response
from starlette.types import ASGIApp

from radar_service.ports.refusal_shapes import RefusalShapesMiddleware


def answer(app: ASGIApp, path: str) -> tuple[int, bytes]:
    """Status and body of an answer, whose length must be that of its head."""
    sent: list[Any] = []

    async def whole() -> None:
        async def send(message: Any) -> None:
            sent.append(message)

        shaped = RefusalShapesMiddleware(app, {"/other": lambda status, reason: {"code": status, "why": reason}})
        await shaped({"type": "http", "path": path}, None, send)  # type: ignore[arg-type]

    asyncio.run(whole())
    body = b"".join(message.get("body", b"") for message in sent[1:])
    assert int(dict(sent[0]["headers"])[b"content-length"]) == len(body)
    return sent[0]["status"], body


@pytest.mark.parametrize(("detail", "reason"), [(["a", "b"], "a; b"), ("Not Found", "Not Found"), ([], "")])
def test_a_refusal_is_written_anew(detail: Any, reason: str) -> None:
    status, body = answer(JSONResponse({"detail": detail}, 404), "/other/x")
    assert status == 404 and json.loads(body) == {"code": 404, "why": reason}


@pytest.mark.parametrize("path", ["/otherwise", "/", "/api/other"])
def test_other_paths_keep_theirs(path: str) -> None:
    assert json.loads(answer(JSONResponse({"detail": ["a"]}, 404), path)[1]) == {"detail": ["a"]}


@pytest.mark.parametrize(
    "response", [JSONResponse({"detail": ["a"]}, 200), JSONResponse({"state": "FAILED"}, 400), Response(b"text", 500)]
)
def test_what_is_no_refusal_or_has_a_shape_is_not_changed(response: Response) -> None:
    assert answer(response, "/other") == (response.status_code, response.body)
