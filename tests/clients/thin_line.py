"""A line to a service that carries so many bytes a second: a proxy on loopback, with a token bucket for all its connections."""

import asyncio
import contextlib
import socket
import threading

PIECE = 4096  # bytes that are read at a time
BURST = 0.05  # s of the rate that pass at once


class ThinLine:
    """A proxy to a port of this machine, in a thread of its own.

    rate: of what comes from the service [bytes/s], None: unlimited; passed: bytes that have come from it.
    """

    def __init__(self, port: int, rate: float | None = None) -> None:
        self.rate, self.passed = rate, 0
        self._port, self._free = port, 0.0
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=(self._serve(),))
        self._end = asyncio.Event()
        self._thread.start()

    def close(self) -> None:
        """Cuts all connections."""
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join()
        self._loop.close()

    async def _serve(self) -> None:
        tasks = set[asyncio.Task[None]]()

        def accepted(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            task = asyncio.ensure_future(self._connect(reader, writer))
            tasks.add(task)
            task.add_done_callback(tasks.discard)

        server = await asyncio.start_server(accepted, sock=self._listener, limit=PIECE)
        await self._end.wait()
        server.close()
        for task in list(tasks):
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            far_reader, far_writer = await asyncio.open_connection("127.0.0.1", self._port, limit=PIECE)
        except OSError:
            return writer.close()
        try:
            ways = (self._pass(reader, far_writer, False), self._pass(far_reader, writer, True))
            parts = [asyncio.create_task(way) for way in ways]
            await asyncio.wait(parts, return_when=asyncio.FIRST_COMPLETED)
            for part in parts:
                part.cancel()
        finally:
            for each in (writer, far_writer):
                each.transport.abort()

    async def _pass(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, is_thin: bool) -> None:
        with contextlib.suppress(OSError):
            while data := await reader.read(PIECE):
                if is_thin:
                    self.passed += len(data)
                    await self._wait(len(data))
                writer.write(data)
                await writer.drain()

    async def _wait(self, size: int) -> None:
        """Waits until the line is free, and takes it for as long as so many bytes need."""
        if self.rate:
            now = self._loop.time()
            self._free = max(self._free, now - BURST) + size / self.rate
            await asyncio.sleep(max(0.0, self._free - now))
