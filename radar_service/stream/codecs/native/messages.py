"""The messages of the native feed as plain data: hello, spokes, truth (see `wire` for the fields). No I/O, no state."""

import math
from datetime import UTC, datetime
from typing import Any

from radar_service.display.video import Layout
from radar_service.radar.parameters import Radar
from radar_service.records import Truth
from radar_service.stream.blind import told_plan, told_warnings
from radar_service.stream.codecs.native import wire
from radar_service.stream.codecs.native.encoding import encode, scale
from radar_service.stream.codecs.native.source_fields import source_fields
from radar_service.stream.feed_request import Mode, View
from radar_service.stream.source import SceneOutline
from radar_service.stream.spokes import RadarInfo, SpokeBatch

TURN = 2.0 * math.pi
ROUNDING = 1e-9  # rad; azimuth - heading of a spoke at the very edge of a sector errs by some 1e-15


def encoding_fields(encoding: str, to: Layout, noise_power: float) -> dict[str, Any]:
    """Returns the `encoding` table of a hello."""
    cells = {"bins": to.bins, "range_step_m": to.step, "range_first_m": to.first, "range_m": to.range}
    reference = {"noise_dbw": 10.0 * math.log10(noise_power)}
    return {"name": encoding, "dtype": wire.DTYPES[encoding], **cells, **scale(encoding, noise_power), **reference}


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
    warnings = told_warnings(scene.warnings, knows_truth)
    return {"name": scene.name, "origin": origin, "bodies": scene.body_count, "warnings": warnings}


def hello(radar: RadarInfo, view: View, mode: Mode) -> dict[str, Any]:
    """Returns the first message of an epoch."""
    epoch, engine, controls = radar.epoch, radar.epoch.engine, dict(radar.controls)
    to, plan = epoch.layout(view.bins), engine.plan.as_dict()
    return {
        "type": "hello",
        "protocol": wire.PROTOCOL,
        "epoch": epoch.name,
        "radar": radar_fields(radar.identity, radar.name, engine.scene.radar, to),
        "scene": scene_fields(engine.scene, radar.truth_allowed),
        "seed": engine.seed,
        "fidelity": engine.fidelity.name,
        "arithmetic": plan.get("arithmetic"),
        "plan": told_plan(plan, radar.truth_allowed),
        "encoding": encoding_fields(view.encoding, to, engine.noise_power),
        "controls": controls,
        "clocks": {"simulated_s": radar.simulated, "utc": datetime.now(UTC).isoformat(), "pace": controls["pace"]},
        "mode": mode,
        "truth": radar.truth_allowed,
        "view": view.as_dict(),
        **({"sources": engine.sources.as_list()} if view.labels or view.powers else {}),
    }


def spokes(batch: SpokeBatch, view: View) -> dict[str, Any]:
    """Returns all spokes of a batch in the view's encoding and bins; `views.apply_view` does the rest of a view."""
    block, engine = batch.block, batch.epoch.engine
    to = batch.epoch.layout(view.bins)
    data = encode(view.encoding, block.power, block.field, to, batch.video, engine.noise_power, batch.before, batch.earlier)
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
    message |= source_fields(batch, view)
    azimuth, heading = (block.azimuth, block.heading) if block.true is None else block.true[:2]
    is_blind = engine.scene.radar.is_blind(azimuth - heading)
    return message | {"blind": is_blind.tolist()} if is_blind.any() else message


def truth(epoch: str, state: Truth) -> dict[str, Any]:
    """Returns the true state of everything."""
    return {"type": "truth", "epoch": epoch, **state.as_dict()}
