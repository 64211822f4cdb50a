"""The requests in progress: when the server stops, the jobs that they wait for are cancelled, and each request is answered."""

import asyncio
import contextlib
from collections.abc import Callable

from fastapi.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

ANSWER_SECONDS = 0.3  # for the answers of cancelled jobs: their processes end in milliseconds
STOPPING = "the server is stopping; try again when it runs"


class Requests:
    """The requests that have no answer yet, but for websockets. Belongs to the event loop.

    cancel_jobs: what cancels the jobs that requests wait for.
    """

    def __init__(self) -> None:
        self.cancel_jobs: list[Callable[[], None]] = []
        self._limits: set[asyncio.Timeout] = set()
        self._answered = asyncio.Event()

    async def follow(self, app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
        """Lets the application answer; a request that `end` finds without an answer gets 503."""
        limit = asyncio.timeout(None)

        async def send_answer(message: Message) -> None:
            self._discard(limit)  # what has begun to be answered is not answered again
            await send(message)

        self._limits.add(limit)
        try:
            async with limit:
                await app(scope, receive, send_answer)
        except TimeoutError:
            if limit not in self._limits or not limit.expired():
                raise
            await JSONResponse({"detail": [STOPPING]}, 503)(scope, receive, send)
        finally:
            self._discard(limit)

    async def end(self) -> None:
        """Cancels all jobs, waits at most ANSWER_SECONDS for the answers, and ends the requests that have none."""
        for cancel in self.cancel_jobs:
            cancel()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(ANSWER_SECONDS):
                while self._limits:
                    self._answered.clear()
                    await self._answered.wait()
        for limit in self._limits:
            limit.reschedule(0.0)

    def _discard(self, limit: asyncio.Timeout) -> None:
        self._limits.discard(limit)
        self._answered.set()


class RequestsMiddleware:
    """Lets `Requests` follow each request."""

    def __init__(self, app: ASGIApp, requests: Requests) -> None:
        self._app, self._requests = app, requests

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            await self._requests.follow(self._app, scope, receive, send)
        else:
            await self._app(scope, receive, send)
