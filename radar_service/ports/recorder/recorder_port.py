"""The recorder of a service as a port."""

from collections.abc import Sequence
from pathlib import Path

from radar_service.ports.port import Port
from radar_service.ports.recorder.service_recorder import ServiceRecorder
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.spokes import SpokeSink


class RecorderPort(Port):
    """Records all radars of a service. They wait for it where a disk is slow, up to the patience of its recorder."""

    name, delays = "recorder", True

    def __init__(self, path: Path, with_truth: bool, sources: SourceRequest) -> None:
        """Opens the file. Raises OSError."""
        self.sources = sources
        self._recorder = ServiceRecorder(path, with_truth, recorded=sources)
        self._recorder.__enter__()

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        """As Port.sinks."""
        return (self._recorder.sink(radar),)

    def close(self) -> None:
        """Writes what waits, and closes the file."""
        self._recorder.__exit__(None, None, None)
