"""JSON bodies of REST: refused with 400 where they are not JSON, with 422 where a key occurs twice in one table."""

from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute

from radar_service.strict_json import DuplicateKeyError, parsed

Refusal = tuple[int, list[str]]  # status, and the lines of `detail`


def parsed_body(content: bytes) -> tuple[Any, Refusal | None]:
    """Returns the content of a body, and why it is refused, None where it is not."""
    try:
        return parsed(content), None
    except DuplicateKeyError as error:
        return None, (422, [f"body: {error}"])
    except (ValueError, RecursionError) as error:
        return None, (400, [f"body: not JSON: {str(error)[:200]}"])


class StrictRoute(APIRoute):
    """A route whose JSON body is read by `parsed_body`; the framework's parser takes the last of two values for one key."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Returns the route's handler for requests that are read so."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            return await handler(_StrictRequest(request.scope, request.receive))

        return handle


class _StrictRequest(Request):
    async def json(self) -> Any:
        """Raises HTTPException."""
        content, refusal = parsed_body(await self.body())
        if refusal:
            raise HTTPException(*refusal)
        return content
