"""A recording, read in process: an epoch of one radar, which yields spokes as a Simulator does."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from radar_service import wire
from radar_service.numerics import Floats
from radar_service.recording.chunk_table import ChunkTable, epochs_of
from radar_service.recording.error import RecordingError
from radar_service.recording.plain import restored
from radar_service.records import SourceList, Spoke, SpokeBlock, Truth, regrouped, square_law
from radar_service.scans import Scan, scan_of
from radar_service.spoke_source import SpokeSourceFault, SpokeSourceInfo, TruthLine
from radar_service.wire import SpokeRows
from radar_service.world import NO_STREAM, SceneOutline, command_from

NO_TRUTH = (
    "a recording has the truth of beam crossings and of the ends of scans, not of every instant; read the truth's stream"
)

NO_LABELS = "the recording has none; record them with --labels"
NO_POWERS = "the recording has none; record them with --powers"


class Recording:
    """One epoch of one radar, a source of spokes. Attributes and methods are those of a Simulator.

    record: what the recording says of the scene, see radar_recording.scene_record; epochs: how many the radar has.
    commands: that the spokes follow.
    """

    def __init__(self, path: str | Path, radar: str = "0", epoch: int = 0, start: float = 0.0) -> None:
        """radar: its id; epoch: number of the epoch, from 0; start: simulated time [s] of the first spoke, or before it.

        A file that was cut short is read up to there. Raises RecordingError and OSError.
        """
        self._table = table = ChunkTable(Path(path))
        epochs = epochs_of(table, radar)
        if not 0 <= epoch < len(epochs):
            raise RecordingError(
                f"epoch: {epoch} is not in {path}, which has {len(epochs)} of radar {radar}, counted from 0"
            )
        self.epochs, self._epoch, self._radar, self._start = len(epochs), epochs[epoch], radar, start
        self.record: Mapping[str, Any] = self._epoch.record
        outline, cells = self.record["outline"], self.record["cells"]
        scene = SceneOutline(
            outline["name"], outline["origin"] and tuple(outline["origin"]), outline["body_count"], tuple(outline["warnings"]),
            restored(self.record["radar"]), tuple(outline["notes"]), stream=tuple(outline.get("stream", NO_STREAM)),
            radar_id=radar, radar_ids=(radar,),
        )  # fmt: skip
        self.commands = tuple(map(command_from, self.own("commands")))
        kept = self.record.get("sources", {"labels": False, "powers": False, "names": []})
        names = {source["number"]: source["name"] for source in kept["names"]}
        sources = SourceList(
            names, "" if kept["labels"] else NO_LABELS, "" if kept["powers"] else NO_POWERS, on_request=False
        )
        self.info = info = SpokeSourceInfo(
            scene, self.record["seed"], restored(self.record["fidelity"]), self.record["plan"], self.record["noise_power"],
            _ranges(**cells), float(cells["step"]), sources,
        )  # fmt: skip
        self.scene, self.seed, self.fidelity, self.sources = scene, info.seed, info.fidelity, sources
        self.range, self.range_step, self.noise_power = info.range, info.range_step, info.noise_power
        self._next_scan = 0

    def __repr__(self) -> str:
        return (
            f"<Recording of {self.scene.name!r}: radar {self._radar}, {self.epochs} epochs, fidelity {self.fidelity.name}>"
        )

    @property
    def start_utc(self) -> datetime | None:
        """UTC at simulated time 0, in whole seconds; None where the file was cut short before it."""
        feed = (wire.unpack(content) for content in self._messages("feed", 0.0))
        clocks = next((message["clocks"] for message in feed if message["epoch"] == self._epoch.name), None)
        if clocks is None:
            return None
        start: datetime = datetime.fromisoformat(clocks["utc"]) - timedelta(seconds=clocks["simulated_s"])
        return (start + timedelta(seconds=0.5)).replace(microsecond=0)

    def blocks(self, *, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields the spokes in blocks of at most `size`, which never span two scans or spokes that the recording lacks."""
        for _, run in groupby(self._stored(), _run_number()):
            yield from regrouped(run, size)

    def spokes(self) -> Iterator[Spoke]:
        """Yields the spokes one by one."""
        for block in self.blocks():
            yield from block.spokes()

    def scans(self) -> Iterator[Scan]:
        """Yields the scans. Azimuths that the recording lacks are NaN."""
        for _, scan in groupby(self._stored(), lambda block: block.scan):
            yield scan_of(scan, self.scene.radar.azimuths)

    def skip_to(self, scan: int) -> None:
        """Leaves out earlier scans."""
        self._next_scan = scan

    @property
    def label_names(self) -> Mapping[int, str]:
        """The name of each source that a label may be the number of; empty where neither labels nor powers are recorded."""
        return self.sources.names

    def truth(self, t: float) -> Truth:
        """Raises SpokeSourceFault: it has not been recorded."""
        raise SpokeSourceFault(NO_TRUTH)

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
        """Returns the lines of a scan, or the header for None, as the truth was recorded; none where it was not."""
        if scan is None:
            header = self.record["truth_header"]
            return [TruthLine(0.0, json.dumps(header))] if header else []
        time = self.scene.radar.schedule(np.array([scan * self.scene.radar.azimuths]))[1][0]
        lines = []
        for message in self._messages("truth", float(time)):
            content = json.loads(message)
            if content.get("scan", scan) > scan:
                break
            if content.get("scan") == scan:
                lines.append(TruthLine(content["time"], message.decode()))
        return lines

    def crossings(self) -> Iterator[dict[str, Any]]:
        """Yields the recorded truth in its order: crossings and snapshots, as the lines of a truth file."""
        lines = (json.loads(message) for message in self._messages("truth", 0.0))
        return (line for line in lines if line["type"] != "header")

    def close(self) -> None:
        """Releases nothing: no file stays open."""

    def own(self, channel: str) -> Iterator[dict[str, Any]]:
        """The commands or errors of this epoch: its first chunk has the last one's too. Older recordings do not name it."""
        for message in self._messages(channel, 0.0):
            content = json.loads(message)
            if content.pop("epoch", self._epoch.name) == self._epoch.name:
                yield content

    def _stored(self) -> Iterator[SpokeBlock]:
        """The recorded blocks of this epoch, from the start that was requested."""
        first, messages = self._next_scan * self.scene.radar.azimuths, self._source_messages()
        for content in self._messages("feed", self._start):
            message = wire.unpack(content)
            if message["type"] != "spokes" or message["epoch"] != self._epoch.name:
                continue
            block = self._block(message)
            keep = max(first - block.first, int(np.searchsorted(block.time, self._start)))
            if keep < len(block):
                yield self._with_sources(block, message["first"], messages).part(max(0, keep), len(block))

    def _source_messages(self) -> Iterator[dict[str, Any]]:
        """The messages of the sources of this epoch; none where they are not recorded."""
        if not (self.sources.no_labels and self.sources.no_powers):
            messages = (wire.unpack(content) for content in self._messages("sources", self._start))
            yield from (message for message in messages if message["epoch"] == self._epoch.name)

    def _with_sources(self, block: SpokeBlock, first: int, messages: Iterator[dict[str, Any]]) -> SpokeBlock:
        """The block with what is recorded of its sources. first: its sequence number. Raises RecordingError."""
        if self.sources.no_labels and self.sources.no_powers:
            return block
        for message in messages:
            if message["first"] == first and message["count"] == len(block):
                return replace(block, labels=wire.labels(message), powers=wire.powers(message))
        raise RecordingError(f"sources: those of spoke {first} are missing; copy the file again")

    def _messages(self, channel: str, start: float) -> Iterator[bytes]:
        """The messages of a channel in this epoch's chunks that end at a simulated time [s] or later."""
        topic, offset = f"/radar/{self._radar}/{channel}", float(self.record["log_offset"])
        return (message.data for message in self._table.messages(topic, self._epoch.chunks, offset + start))

    def _block(self, message: Mapping[str, Any]) -> SpokeBlock:
        rows, azimuths = SpokeRows.of(dict(message)), self.scene.radar.azimuths
        power = square_law(rows.samples)
        if "power" in message:
            power = np.frombuffer(message["power"], dtype="<f4").reshape(rows.samples.shape)
        return SpokeBlock(
            first=message["scan"] * azimuths + message["index"], scan=message["scan"], index=message["index"],
            time=rows.time, azimuth=rows.azimuth, heading=rows.heading, course=rows.course, speed=rows.speed,
            position=rows.position, range=self.range, range_step=self.range_step, field=rows.samples, power=power,
            commands=len(self.commands),
        )  # fmt: skip


def _ranges(bins: int, first: float, step: float) -> Floats:
    """Ranges of the samples (bins,) [m], with the rounding of the engine that made them."""
    number = np.arange(bins, dtype=np.float64)
    return (number + 0.5) * step if first == 0.5 * step else first + number * step


def _run_number() -> Callable[[SpokeBlock], int]:
    """Returns a function of consecutive blocks whose value changes with the scan and where spokes are missing."""
    last, number = -1, 0

    def run(block: SpokeBlock) -> int:
        nonlocal last, number
        if block.first != last or block.index == 0:
            number += 1
        last = block.first + len(block)
        return number

    return run


read = Recording
