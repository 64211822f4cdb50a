"""The native feed as a codec: its messages as plain data, the samples in them, and their bytes. See `wire` for the fields.

Of samples there are the video that a display shows (u8), and four encodings that are untouched by its controls.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service import wire
from radar_service.display.video import (
    DB_PER_STEP,
    Layout,
    decibels,
    noise_threshold_db,
    peaks,
    quantise,
    strongest,
)
from radar_service.numerics import Profiles, Singles
from radar_service.radar import Radar
from radar_service.records import Truth
from radar_service.service.access import told_fields, told_plan
from radar_service.service.codecs.native.views import apply_view, request_from_query, source_fields, trim
from radar_service.service.feed_request import FeedRequest, Mode, View
from radar_service.service.spokes import RadarInfo, SpokeBatch
from radar_service.world import SceneOutline

LOG_DB_PER_STEP = 0.5  # of u8-log: 127 dB, from below the noise to a ship alongside
SCALE_BELOW_NOISE_DB = 20.0  # u8-log begins this far below the mean noise, so that noise keeps its distribution


def log_offset_db(noise_power: float) -> float:
    """Level [dBW] of byte 0 of u8-log, a whole number of dB."""
    return math.floor(10.0 * math.log10(noise_power) - SCALE_BELOW_NOISE_DB)


def scale(encoding: str, noise_power: float, pulses: int = 1) -> dict[str, float]:
    """`db_per_step` and `offset_db` [dBW], so that byte b > 0 is the middle of its step, of the encodings in steps."""
    if encoding == "u8":
        return {"db_per_step": DB_PER_STEP, "offset_db": noise_threshold_db(noise_power, pulses) - 0.5 * DB_PER_STEP}
    if encoding == "u8-log":
        return {"db_per_step": LOG_DB_PER_STEP, "offset_db": log_offset_db(noise_power)}
    return {}


def encode(encoding: str, power: Singles, field: Profiles, to: Layout, noise_power: float) -> NDArray[np.generic]:
    """Cells (K, N) as samples (K, bins) in one of the encodings of `wire.DTYPES`, but for u8: see `SpokeBatch.video_bytes`.

    power [W] and field [sqrt(W)] are of the same cells; noise_power [W] is the reference of u8-log.
    """
    if encoding == "c64":
        return strongest(field, to).astype("<c8")
    top = peaks(power, to)
    if encoding == "u8-log":
        return quantise(decibels(top), log_offset_db(noise_power), LOG_DB_PER_STEP)
    if encoding == "f16":
        return decibels(top).astype("<f2")
    if encoding == "f32":
        return top.astype("<f4")
    raise ValueError(f'encoding: "{encoding}" is not one of u8, u8-log, f16, f32, c64')


def encoding_fields(encoding: str, to: Layout, noise_power: float) -> dict[str, Any]:
    """Returns the `encoding` table of a hello."""
    cells = {"bins": to.bins, "range_step_m": to.step, "range_first_m": to.first, "range_m": to.range}
    reference = {"noise_dbw": 10.0 * math.log10(noise_power)}
    return {
        "name": encoding,
        "dtype": wire.DTYPES[encoding],
        **cells,
        **scale(encoding, noise_power, to.pulses),
        **reference,
    }


def radar_fields(identity: str, name: str, radar: Radar, to: Layout) -> dict[str, Any]:
    """Returns the `radar` table of a hello and of the REST answers."""
    return {
        "id": identity,
        "name": name,
        "azimuths": radar.azimuths,
        "rpm": 60.0 / radar.rotation_period,
        "bins": to.samples,
        "range_step_m": to.native_step,
        "range_max_m": radar.range_max,
        "beamwidth_deg": math.degrees(radar.beamwidth),
        "beamwidth_el_deg": math.degrees(radar.beamwidth_el),
        "frequency_hz": radar.frequency,
        "modulation": radar.modulation,
        "bandwidth_hz": radar.bandwidth,
        "pulse_s": radar.pulse,
        "prf_hz": radar.prf,
        "power_w": radar.power,
        "height_m": radar.height,
        "blind_sectors_deg": [[math.degrees(a), math.degrees(b)] for a, b in radar.blind_sectors],
    }


def scene_fields(scene: SceneOutline, knows_truth: bool) -> dict[str, Any]:
    """Returns the `scene` table of a hello and of the REST answers. knows_truth: whether who reads it may know the truth."""
    origin = scene.origin and {"latitude_deg": scene.origin[0], "longitude_deg": scene.origin[1]}
    warnings = list(scene.warnings) if knows_truth else []
    stream = {"stream": list(scene.stream)} if any(scene.stream) else {}
    return {"name": scene.name, "origin": origin, "bodies": scene.body_count, "warnings": warnings, **stream}


def hello(radar: RadarInfo, view: View, mode: Mode) -> dict[str, Any]:
    """Returns the first message of an epoch."""
    epoch, known, controls = radar.epoch, radar.epoch.info, dict(radar.controls)
    to, plan = epoch.layout(view.bins), known.plan
    fields = {
        "type": "hello",
        "protocol": wire.PROTOCOL,
        "epoch": epoch.name,
        "radar": radar_fields(radar.identity, radar.name, known.scene.radar, to),
        "scene": scene_fields(known.scene, radar.truth_allowed),
        "seed": known.seed,
        "fidelity": known.fidelity.name,
        "arithmetic": plan.get("arithmetic"),
        "plan": told_plan(plan, radar.truth_allowed),
        "encoding": encoding_fields(view.encoding, to, known.noise_power),
        "controls": controls,
        "clocks": {"simulated_s": radar.simulated, "utc": radar.utc.isoformat(), "pace": controls["pace"]},
        "mode": mode,
        "truth": radar.truth_allowed,
        "view": view.as_dict(),
        **({"sources": known.sources.as_list()} if view.sources else {}),
    }
    return told_fields(fields, epoch.is_blind)


def spokes(batch: SpokeBatch, view: View) -> dict[str, Any]:
    """Returns all spokes of a batch in the view's encoding and bins, not compressed."""
    block, known = batch.block, batch.epoch.info
    to = batch.epoch.layout(view.bins)
    if view.encoding == "u8":
        data: NDArray[np.generic] = batch.video_bytes(to)
    else:
        data = encode(view.encoding, block.power, block.field, to, known.noise_power)
    message = {
        "type": "spokes",
        "epoch": batch.epoch.name,
        "first": batch.first,
        "count": len(block),
        "scan": block.scan,
        "index": block.index,
        "time": block.time.tolist(),
        "azimuth": wire.turn_from_radians(block.azimuth),
        "heading": wire.turn_from_radians(block.heading),
        "position": block.position.tolist(),
        "course": wire.turn_from_radians(block.course),
        "speed": block.speed.tolist(),
        "bins": to.bins,
        "range_step_m": to.step,
        "range_first_m": to.first,
        "range": to.range,
        "encoding": view.encoding,
        "data": data.tobytes(),
    }
    if view.sources:
        message |= source_fields(batch, view)
    azimuth, heading = (block.azimuth, block.heading) if block.true is None else block.true[:2]
    is_blind = known.scene.radar.is_blind(azimuth - heading)
    return message | {"blind": is_blind.tolist()} if is_blind.any() else message


class NativeCodec:
    """Packs the messages of the native feed."""

    name, port, rising = "native", "feed", False
    path = "/api/radars/{radar}/feed"

    def request(self, query: Mapping[str, str], is_local: bool) -> FeedRequest:
        """Returns the request of a query string. Raises ValueError that names the parameter."""
        return request_from_query(query, is_local)

    def hello(self, radar: RadarInfo, view: View, mode: Mode) -> bytes:
        """Returns the hello of an epoch."""
        return wire.pack(hello(radar, view, mode))

    def spokes(self, batch: SpokeBatch, view: View) -> bytes:
        """Returns the spokes in the view's encoding, filtered, merged and compressed as the view requests."""
        message = spokes(batch, view)
        if not view.is_whole:
            message = apply_view(message, view)
        return wire.pack(wire.packed(message, view.compression))

    def truth(self, epoch: str, state: Truth) -> bytes:
        """Returns the true state."""
        return wire.pack({"type": "truth", "epoch": epoch, **state.as_dict()})

    def no_truth(self, epoch: str, time: float, until: float, count: int, reason: str) -> bytes:
        """Returns the announcement of truths that will not come."""
        fields = {"time": time, "until": until, "count": count, "reason": reason}
        return wire.pack({"type": "no_truth", "epoch": epoch, **fields})

    def gap(self, epoch: str, first: int, count: int, reason: str) -> bytes:
        """Returns the announcement of lost spokes."""
        return wire.pack({"type": "gap", "epoch": epoch, "first": first, "count": count, "reason": reason})

    def bye(self, epoch: str, reason: str) -> bytes:
        """Returns the last message."""
        return wire.pack({"type": "bye", "epoch": epoch, "reason": reason})

    def trim(self, data: bytes, count: int) -> bytes:
        """Returns a message of spokes cut down to its last `count` spokes."""
        return wire.pack(trim(wire.unpack(data), count))
