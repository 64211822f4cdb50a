"""The channels of one radar in a recording, each under /radar/ID.

sources: where labels or powers are recorded, those of the spokes that come next on feed, as a `sources` message. Its fields are
those of a `spokes` message, without the samples and what belongs to these.
feed: the messages of the native feed with every cell, `encoding=c64`. A `spokes` message has three keys more, as the wire
rounds angles: azimuth_rad, heading_rad and course_rad. Where the power is not the square of the field it is there too.
scene: at the start of each epoch what is computed, and how; see `scene_record`.
truth: the lines of a truth file, once a scan.
commands: those that the spokes of the epoch follow, as JSON with its name, each before the first spokes that know it.
errors: on purpose, as tables of a scene, where they change.
ppi: a picture at the end of each scan.

The document of a scene is as its file has it, with the hashes of the files that it names.
"""

import base64
import hashlib
import json
import logging
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from radar_service import wire
from radar_service.display.video import Controls, peaks, strongest
from radar_service.recording.json_schema import COMMAND, COMPRESSED_IMAGE, scene_schema, truth_schema
from radar_service.recording.plain import plain
from radar_service.recording.recording_file import NANOSECONDS, RecordingFile
from radar_service.records import SourceRequest, square_law
from radar_service.scene_file import model_and_folder, model_at_range, radar_table
from radar_service.scene_file.error_tables import error_tables
from radar_service.service.codecs.native import messages, views
from radar_service.service.feed_request import View
from radar_service.service.logs import log_event
from radar_service.service.radio.last_scan import LastScan, draw
from radar_service.service.scene_request import SceneRequest
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from radar_service.spoke_source import SpokeSourceFault, TruthLine
from radar_service.world import ErrorSettings, SceneError

FILE_KEYS = ("mesh", "heightmap", "track")  # of a scene, that name a file
FORMAT = 1  # version of these channels
VIEW = View("c64")
CODEC = messages.NativeCodec()
NOTHING = SourceRequest()
PICTURE_SIZE = 600  # pixels
OUTLINE = ("name", "origin", "body_count", "warnings", "notes", "stream")  # fields of a SceneOutline besides the radar


def scene_document(scene_request: SceneRequest) -> tuple[dict[str, Any] | None, dict[str, str | None]]:
    """Returns the scene of a scene request as its file has it, and the SHA-256 of each file that it names, by its name.

    The rate of rotation and the range scale are those of the scene request. The document is None where the scene's file has
    gone or no longer has that scale; so is the hash of a file.
    """
    try:
        model, folder = model_and_folder(scene_request.scene_input, None)
        model = model_at_range(model, scene_request.radar, scene_request.range_m)
    except SceneError:
        return None, {}
    document: dict[str, Any] = model.model_dump(mode="json", by_alias=True, exclude_unset=True)
    if scene_request.rpm is not None:
        radar_table(document, scene_request.radar)["rpm"] = scene_request.rpm
    return document, {name: file_hash(folder, name) for name in sorted(set(_file_names(document)))}


def _file_names(part: Any) -> Iterator[str]:
    if isinstance(part, dict):
        for key, value in part.items():
            if key in FILE_KEYS and isinstance(value, str):
                yield value
            yield from _file_names(value)
    elif isinstance(part, list):
        for item in part:
            yield from _file_names(item)


def file_hash(folder: Path | None, name: str) -> str | None:
    """Returns the SHA-256 of a file that a scene names, None where it cannot be read."""
    try:
        return hashlib.sha256(((folder or Path()) / name).read_bytes()).hexdigest()
    except OSError:
        return None


class RadarRecording:
    """Writes what a radar sends. All methods raise OSError."""

    def __init__(self, file: RecordingFile, identity: str, with_truth: bool, recorded: SourceRequest = NOTHING) -> None:
        """with_truth: whether the truth too; recorded: what spokes tell of their sources."""
        self._file, self._with_truth, self._recorded = file, with_truth, recorded
        self._view = View("c64", labels=recorded.labels, powers=recorded.powers)
        self._feed = file.channel(f"/radar/{identity}/feed", "msgpack")
        self._scene = file.channel(f"/radar/{identity}/scene", "json", scene_schema(bool(recorded)))
        self._truth = file.channel(f"/radar/{identity}/truth", "json", truth_schema())
        self._commands = file.channel(f"/radar/{identity}/commands", "json", COMMAND)
        self._error_tables = file.channel(
            f"/radar/{identity}/errors", "json", {"title": "radar_service.Errors", "type": "object"}
        )
        self._ppi = file.channel(f"/radar/{identity}/ppi", "json", COMPRESSED_IMAGE)
        self._sources = file.channel(f"/radar/{identity}/sources", "msgpack") if recorded else None
        self._offset = self._logged = 0.0
        self._next = self._known = 0  # number of the next spoke; commands of the epoch that are written
        self._errors: ErrorSettings | None = None
        self._last_scan: LastScan | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch. Log times go on where simulated time starts again."""
        epoch, time = radar.epoch, radar.simulated
        self._offset += max(0.0, self._logged - (self._offset + time))
        self._next, self._known, self._errors = 0, 0, epoch.info.scene.errors
        self._last_scan = self._last_scan or LastScan(epoch.spoke_source)
        self._last_scan.open_epoch(radar)
        header = self._truth_lines(epoch, None)
        record = {
            **scene_record(radar), **sources_record(epoch, self._recorded), "log_offset": self._offset,
            "truth_header": json.loads(header[0].text) if header else None,
        }  # fmt: skip
        self._write(self._scene, time, json.dumps(record, allow_nan=False).encode())
        for line in header:
            self._write(self._truth, time, line.text.encode())
        self._write(self._feed, time, CODEC.hello(radar, VIEW, "lossless"))
        self._file.flush()  # what the epoch is of can be read however soon the file is cut short

    def send(self, batch: SpokeBatch) -> None:
        """Writes spokes, and at the end of a scan its truth and its picture."""
        block = batch.block
        self._write_commands(batch.epoch, float(block.time[0]))
        if batch.errors != self._errors:
            self._errors, tables = batch.errors, None if batch.errors is None else error_tables(batch.errors)
            content = {"epoch": batch.epoch.name, "spoke": block.first, "errors": tables}
            self._write(self._error_tables, float(block.time[0]), json.dumps(content).encode())
        fields = views.source_fields(batch, self._view)
        if fields and self._sources:
            self._write(self._sources, float(block.time[-1]), wire.pack(sources_message(batch) | fields))
        self._write(self._feed, float(block.time[-1]), wire.pack(spokes_message(batch)))
        self._next = batch.first + len(batch)
        assert self._last_scan is not None, "open_epoch comes first"
        self._last_scan.send(batch)
        if block.index + len(block) == batch.epoch.info.radar.azimuths:
            self._end_scan(batch)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Writes that spokes never come, nor those before that have not."""
        missing = first + count - self._next
        self._feed(self._logged, self._logged - self._offset, CODEC.gap(epoch, self._next, missing, reason))
        self._next += missing

    def _write_commands(self, epoch: Epoch, time: float) -> None:
        """Writes the commands that came since the last spokes, before those of this time [s]."""
        for command in epoch.commands.since(self._known):
            self._write(self._commands, time, json.dumps({"epoch": epoch.name} | command.as_dict()).encode())
            self._known += 1

    def _end_scan(self, batch: SpokeBatch) -> None:
        for line in self._truth_lines(batch.epoch, batch.block.scan):
            self._write(self._truth, line.time, line.text.encode())
        time = float(batch.block.time[-1])
        self._write(self._ppi, time, json.dumps(self._picture(batch.epoch, batch.video, self._offset + time)).encode())
        self._file.flush()

    def _truth_lines(self, epoch: Epoch, scan: int | None) -> list[TruthLine]:
        """The truth of a scan, or the header; none where it is not recorded, or the spoke source fails, which another one
        replaces."""
        try:
            return epoch.spoke_source.truth_lines(scan) if self._with_truth else []
        except SpokeSourceFault:
            return []

    def _picture(self, epoch: Epoch, video: Controls, log_time: float) -> dict[str, Any]:
        assert self._last_scan is not None, "open_epoch comes first"
        known, revolution = epoch.info, self._last_scan.read()
        image = draw(
            revolution.rows, known.radar.azimuths, epoch.layout(None), video, known.noise_power, known.scene.name,
            PICTURE_SIZE, epoch.range, revolution.heading,
        )  # fmt: skip
        seconds, nanoseconds = divmod(round(log_time * NANOSECONDS), round(NANOSECONDS))
        return {
            "timestamp": {"sec": seconds, "nsec": nanoseconds}, "frame_id": "radar",
            "data": base64.b64encode(image).decode(), "format": "png",
        }  # fmt: skip

    def _write(self, channel: Any, time: float, content: bytes) -> None:
        channel(self._offset + time, time, content)
        self._logged = max(self._logged, self._offset + time)


def spokes_message(batch: SpokeBatch) -> dict[str, Any]:
    """Returns a batch as the feed channel has it."""
    block, to = batch.block, batch.epoch.layout(None)
    power, field = peaks(block.power, to), strongest(block.field, to)
    exact: dict[str, Any] = {
        "azimuth_rad": block.azimuth.tolist(), "heading_rad": block.heading.tolist(), "course_rad": block.course.tolist(),
    }  # fmt: skip
    if not np.array_equal(square_law(field), power):
        exact["power"] = power.astype("<f4").tobytes()
    return messages.spokes(batch, VIEW) | exact


def sources_message(batch: SpokeBatch) -> dict[str, Any]:
    """Returns which spokes a message of the sources channel is of."""
    block = batch.block
    which = {"first": batch.first, "count": len(block), "scan": block.scan, "index": block.index}
    return {"type": "sources", "epoch": batch.epoch.name, **which, "bins": batch.epoch.layout(None).bins}


def sources_record(epoch: Epoch, recorded: SourceRequest) -> Mapping[str, Any]:
    """Returns what the scene's message says of sources: whether labels and powers are recorded, and the table of sources.

    A radar that cannot tell them has none: then a line in the log says why.
    """
    sources = epoch.info.sources
    if not recorded:
        return {}
    try:
        sources.check(recorded)
    except ValueError as error:
        log_event("sources are not all recorded", logging.WARNING, scene=epoch.info.scene.name, reason=str(error))
    recordable = sources.to_request(recorded)
    return {"sources": {"labels": recordable.labels, "powers": bool(recordable.powers), "names": sources.as_list()}}


def scene_record(radar: RadarInfo) -> Mapping[str, Any]:
    """Returns what is computed in an epoch, and how.

    outline: of the scene; radar: its parameters; cells: number, range of the first one and step [m]; document, files: see
    `scene_document`; fidelity: as resolved; plan, seed; noise_power: of a cell [W]; controls: as REST gives them.
    """
    epoch, known = radar.epoch, radar.epoch.info
    to, scene = epoch.layout(None), known.scene
    document, files = scene_document(epoch.scene_request) if epoch.scene_request else (None, {})
    outline = {name: getattr(scene, name) for name in OUTLINE}
    return {
        "format": FORMAT, "epoch": epoch.name, "id": radar.identity, "name": radar.name, "outline": outline,
        "radar": plain(scene.radar), "cells": {"bins": to.bins, "first": to.first, "step": to.step},
        "document": document, "files": files, "fidelity": plain(known.fidelity), "plan": known.plan,
        "seed": known.seed, "noise_power": known.noise_power, "controls": dict(radar.controls),
    }  # fmt: skip
