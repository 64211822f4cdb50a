"""What the feed says, built from the engine's records: hello, spokes, truth (see wire for the fields). No I/O, no state."""

import math
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from radar_service.display.video import Controls, Layout, encode, layout, scale
from radar_service.fidelity import Fidelity
from radar_service.radar.parameters import Radar
from radar_service.records import SpokeBlock, Truth
from radar_service.scene.world import Scene
from radar_service.stream import wire


class Planned(Protocol):
    """A plan, as far as the stream is concerned."""

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""


class Engine(Protocol):
    """What the stream needs of a simulator."""

    @property
    def scene(self) -> Scene:
        """The scene that runs."""

    @property
    def seed(self) -> int:
        """What its randomness hangs on."""

    @property
    def fidelity(self) -> Fidelity:
        """How it is computed."""

    @property
    def plan(self) -> Planned:
        """What is modelled."""

    @property
    def noise_power(self) -> float:
        """Thermal noise of a cell [W], whether or not noise is on."""

    @property
    def range(self) -> NDArray[np.float64]:
        """Where samples stand (N,) [m]."""

    @property
    def range_step(self) -> float:
        """From sample to sample [m]."""

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        """Consecutive blocks of at most `size` spokes, none of which spans two scans; for ever when scans is None."""

    def skip_to(self, scan: int) -> None:
        """Let `scan` be the next one, counted from 0."""

    def truth(self, t: float) -> Truth:
        """State of everything at time t [s]."""


def engine_layout(engine: Engine, bins: int | None, range_max: float | None) -> Layout:
    """How this engine's cells become `bins` bins out to range_max [m]."""
    return layout(engine.range.size, float(engine.range[0]), engine.range_step, bins, range_max)


def encoding_fields(encoding: str, to: Layout, noise_power: float) -> dict[str, Any]:
    """The `encoding` table of a hello."""
    place = {"bins": to.bins, "range_step_m": to.step, "range_first_m": to.first, "range_m": to.range}
    reference = {"noise_dbw": 10.0 * math.log10(noise_power)}
    return {"name": encoding, "dtype": wire.DTYPES[encoding], **place, **scale(encoding, noise_power), **reference}


def radar_fields(identity: str, name: str, radar: Radar, to: Layout) -> dict[str, Any]:
    """The `radar` table of a hello, and of the REST answers."""
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
        "height_m": radar.height,
        "blind_sectors_deg": [[math.degrees(a), math.degrees(b)] for a, b in radar.blind_sectors],
    }


def scene_fields(scene: Scene) -> dict[str, Any]:
    """The `scene` table of a hello, and of the REST answers."""
    origin = scene.origin and {"latitude_deg": scene.origin[0], "longitude_deg": scene.origin[1]}
    return {"name": scene.name, "origin": origin, "bodies": len(scene.bodies), "warnings": list(scene.warnings)}


def hello(
    epoch: str, identity: str, name: str, engine: Engine, encoding: str, to: Layout, simulated: float,
    controls: Mapping[str, Any], mode: str, truth: bool,
) -> dict[str, Any]:  # fmt: skip
    """The first message of an epoch. simulated: time of the next spoke [s]."""
    return {
        "type": "hello",
        "protocol": wire.PROTOCOL,
        "epoch": epoch,
        "radar": radar_fields(identity, name, engine.scene.radar, to),
        "scene": scene_fields(engine.scene),
        "seed": engine.seed,
        "fidelity": engine.fidelity.name,
        "plan": engine.plan.as_dict(),
        "encoding": encoding_fields(encoding, to, engine.noise_power),
        "controls": dict(controls),
        "clocks": {"simulated_s": simulated, "utc": datetime.now(UTC).isoformat(), "pace": controls["pace"]},
        "mode": mode,
        "truth": truth,
    }


def spokes(
    epoch: str, first: int, block: SpokeBlock, encoding: str, to: Layout, controls: Controls, engine: Engine
) -> dict[str, Any]:
    """A block as the feed sends it; first: sequence number of its first spoke."""
    data = encode(encoding, block.power, block.field, to, controls, engine.noise_power)
    message = {
        "type": "spokes",
        "epoch": epoch,
        "first": first,
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
        "encoding": encoding,
        "data": data.tobytes(),
    }
    hidden = engine.scene.radar.is_blind(block.azimuth - block.heading)
    return message | {"blind": hidden.tolist()} if hidden.any() else message


def truth(epoch: str, state: Truth) -> dict[str, Any]:
    """The state of everything, as the feed and REST send it."""
    return {"type": "truth", "epoch": epoch, **state.as_dict()}
