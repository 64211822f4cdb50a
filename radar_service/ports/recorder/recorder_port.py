"""Records the radars of a running service, in a thread of its own, so that a disk neither stops a feed nor ends it."""

import logging
import threading
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import IO, NamedTuple

from radar_service.ports.port import Port
from radar_service.recording.radar_recording import NOTHING, RadarRecording
from radar_service.recording.recording_file import RecordingFile, created
from radar_service.records import SourceRequest
from radar_service.service.logs import log_event
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink

MAX_WAITING = 64 * 2**20  # bytes of spokes that wait for the disk; beyond it the radars wait too
PATIENCE = 20.0  # s that the radars wait for the disk: twice the time that a truth may take


class Work(NamedTuple):
    """A piece of work of the recorder's thread. size: of the spokes that it holds [bytes]; ends_scan: whether they end one."""

    do: Callable[[], None]
    size: int = 0
    ends_scan: bool = False


class RecorderPort(Port):
    """Records all radars of a service, which wait for it where a disk is slow.

    A disk that is full, or takes longer than `patience` [s], ends the recording with a line in the log, not the feed.

    fault: why the recording has ended, None while it goes on.
    """

    name, delays = "recorder", True

    def __init__(
        self, path: Path, with_truth: bool, sources: SourceRequest = NOTHING, patience: float = PATIENCE,
        create: Callable[[Path], IO[bytes]] = created,
    ) -> None:  # fmt: skip
        """Opens the file. sources: what spokes tell of their sources; create: returns the empty file. Raises OSError."""
        self.fault: str | None = None
        self._path, self._with_truth, self._patience, self.sources = path, with_truth, patience, sources
        self._file = RecordingFile(path, create)
        self._work: deque[Work] = deque()
        self._recordings: dict[str, RadarRecording] = {}
        self._waiting = self._scan_ends = 0
        self._changed, self._closing, self._has_begun = threading.Condition(), False, False
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        """Returns the sink of a radar."""
        if not self._has_begun:
            self._recording(radar)  # its channels are in the first chunk
        return (RecordingSink(partial(self._recording, radar), self.put),)

    def close(self) -> None:
        """Writes what waits, and closes the file."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._thread.join(self._patience)

    def _recording(self, radar: str) -> RadarRecording:
        """The channels of a radar. Once the thread writes, it alone may add some."""
        if radar not in self._recordings:
            self._recordings[radar] = RadarRecording(self._file, radar, self._with_truth, self.sources)
        return self._recordings[radar]

    def put(self, work: Work) -> None:
        """Queues `work` for the thread, in order. Waits where too much waits already, or the end of another scan."""
        with self._changed:
            if not self._changed.wait_for(lambda: self.fault or self._has_room(work), self._patience):
                self._end(f"{self._path}: the disk took more than {self._patience:g} s")
            if self.fault is None:
                self._has_begun = True
                self._work.append(work)
                self._waiting += work.size
                self._scan_ends += work.ends_scan
                self._changed.notify_all()

    def _run(self) -> None:
        try:
            while work := self._next():
                work.do()
                with self._changed:
                    self._waiting -= work.size
                    self._scan_ends -= work.ends_scan
                    self._changed.notify_all()
        except OSError as error:
            self._end(f"{error.filename}: {error.strerror}")
        except Exception as error:  # of any kind: the feed must go on
            self._end(f"{self._path}: {type(error).__name__}: {error}")
        try:
            self._file.close()
        except OSError as error:
            self._end(f"{error.filename}: {error.strerror}")

    def _next(self) -> Work | None:
        with self._changed:
            self._changed.wait_for(lambda: self._work or self._closing or self.fault)
            return self._work.popleft() if self._work else None

    def _has_room(self, work: Work) -> bool:
        return self._waiting < MAX_WAITING and not (work.ends_scan and self._scan_ends)

    def _end(self, reason: str) -> None:
        """Ends the recording, where it has not ended."""
        with self._changed:
            if self.fault is not None:
                return
            self.fault = reason
            self._work.clear()
            self._changed.notify_all()
            log_event("recording failed, the feed goes on", logging.ERROR, reason=reason)


class RecordingSink(SpokeSink):
    """Hands what a radar sends to the recorder's thread."""

    def __init__(self, recording: Callable[[], RadarRecording], put: Callable[[Work], None]) -> None:
        """recording: returns the channels of the radar; the thread calls it."""
        self._recording, self._put = recording, put

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch."""
        self._put(Work(lambda: self._recording().open_epoch(radar)))

    def send(self, batch: SpokeBatch) -> None:
        """Takes spokes."""
        block = batch.block
        ends_scan = block.index + len(block) == batch.epoch.info.radar.azimuths
        self._put(Work(lambda: self._recording().send(batch), block.nbytes, ends_scan))

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Takes the notice of spokes that never come."""
        self._put(Work(lambda: self._recording().skip(epoch, first, count, reason)))
