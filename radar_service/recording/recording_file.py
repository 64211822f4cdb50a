"""An MCAP file while it is written: channels, messages with a simulated time, chunks that are whole on disk."""

import contextlib
import json
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from radar_service.recording.mcap_library import CompressionType, Writer

PROFILE = "radar-service"
CHUNK = 2**20  # bytes before compression: what a file that is cut short loses at most, besides the scan that was being sent
NANOSECONDS = 1e9


def created(path: Path) -> IO[bytes]:
    """Returns a new file. Raises OSError."""
    return path.open("wb")


class RecordingFile:
    """Writes a file, as a context manager. All methods raise OSError that names the file; after one nothing is written."""

    def __init__(self, path: Path, create: Callable[[Path], IO[bytes]] = created, profile: str = PROFILE) -> None:
        """create: returns the empty file; profile: of its channels."""
        self._path, self._failed = path, False
        self._file = create(path)
        self._writer = Writer(self._file, chunk_size=CHUNK, compression=CompressionType.ZSTD)
        with self._named_errors():
            self._writer.start(profile, f"radar-service {version('radar-service')}")

    def channel(
        self, topic: str, encoding: str, schema: Mapping[str, Any] | None = None
    ) -> Callable[[float, float, bytes], None]:
        """Returns what writes a message to a new channel: log time [s], simulated time [s], content.

        Channels that come before the first message are in the first chunk, where readers look for them.
        """
        if schema is None:
            return self.typed_channel(topic, encoding)
        return self.typed_channel(topic, encoding, schema["title"], "jsonschema", json.dumps(schema).encode())

    def typed_channel(
        self, topic: str, encoding: str, name: str = "", form: str = "", schema: bytes = b""
    ) -> Callable[[float, float, bytes], None]:
        """The same with a schema of another form; name: of the type, none for a channel without a schema."""
        number = self._writer.register_schema(name, form, schema) if name else 0
        channel = self._writer.register_channel(topic, encoding, number)

        def write(log_time: float, time: float, content: bytes) -> None:
            with self._named_errors():
                self._writer.add_message(channel, round(log_time * NANOSECONDS), content, round(time * NANOSECONDS))

        return write

    def flush(self) -> None:
        """Ends the chunk, so that all messages are on disk."""
        with self._named_errors():
            self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Writes the index and closes the file; after an error it only closes the file."""
        try:
            if not self._failed:
                with self._named_errors():
                    self._writer.finish()  # type: ignore[no-untyped-call]
                    self._file.flush()
        finally:
            with contextlib.suppress(OSError):  # what could not be written before
                self._file.close()

    @contextlib.contextmanager
    def _named_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._failed = True
            raise OSError(error.errno, error.strerror, str(self._path)) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
