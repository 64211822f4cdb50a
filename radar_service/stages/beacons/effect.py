"""Beacons as an effect: their keys, their records in SI units, what `check` says of them, and warnings of idle ones."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from radar_service.numerics import SPEED_OF_LIGHT
from radar_service.radar import Radar
from radar_service.stages.beacons.beacon import (
    DOT_SPACING,
    S_BAND,
    SART_CYCLES,
    X_BAND,
    Beacon,
    BeaconTruth,
    Racon,
    Sart,
    morse_dots,
)
from radar_service.stages.effect import Effect, Source
from radar_service.stages.fields import Number, Section, record_of
from radar_service.world import Body, Installation, Mesh

if TYPE_CHECKING:
    from radar_service.world import Scene

Instant = Annotated[float, Field(strict=True, ge=0, le=1e9)]  # s of simulated time
Part = Annotated[float, Field(strict=True, ge=-1000, le=1000)]  # m
BANDS = {"x": (X_BAND,), "s": (S_BAND,), "both": (X_BAND, S_BAND)}
ABOVE = 0.5  # m of an antenna above the highest point of its body
MAX_ANSWER = 200e-6  # s, of a racon
MAX_MULTIPATH = 2.0  # of the field, direct and reflected ray in phase: a pulse triggers as much farther


class BeaconSection(Section):
    """The keys that racons and SARTs share."""

    offset_m: tuple[Part, Part, Part] | None = Field(
        None, description="starboard, forward, up of its antenna from the body's origin; default: above its highest point"
    )
    sensitivity_dbm: Number = Field(
        -50.0, ge=-120, le=60, description="least power of a pulse that triggers it, at an isotropic antenna"
    )
    max_pulse_s: Number | None = Field(
        None, gt=0, le=1, description="longest pulse that triggers it; default: power alone decides"
    )


class RaconModel(BeaconSection):
    """A racon, which answers radars by a letter in Morse code behind its echo (ITU-R M.824)."""

    letter: Annotated[str, Field(strict=True, pattern=r"^[A-Z]{1,3}$")] = Field(
        description="its Morse code, one to three letters; a dash is three dots"
    )
    band: Literal["x", "s", "both"] = Field("both", description="9.3 to 9.5 GHz, 2.9 to 3.1 GHz")
    mode: Literal["agile", "sweep"] = Field("agile", description="on the radar's own carrier, or sweeping through the band")
    sweep_s: Number = Field(72.0, ge=1, le=3600, description='time of a sweep through the band, of mode "sweep"')
    tuning_error_hz: Number = Field(0.0, ge=-50e6, le=50e6, description='of its carrier from the radar\'s, of mode "agile"')
    mark_m: Number = Field(
        3704.0, ge=10, le=30_000, description="length of its answer in range; 2 NM: a fifth of the 10 NM that it serves"
    )
    dot_s: Number | None = Field(None, ge=1e-8, le=1e-4, description="length of a dot; default: by `mark_m`")
    delay_s: Number = Field(0.5e-6, ge=0, le=1e-4, description="from the leading edge of a pulse to the answer")
    power_dbm: Number = Field(30.0, ge=-60, le=90, description="equivalent isotropic radiated power")
    on_s: Annotated[float, Field(strict=True, gt=0, le=86_400)] = Field(
        20.0, description="answers so long, by turns with `off_s`"
    )
    off_s: Annotated[float, Field(strict=True, ge=0, le=86_400)] = Field(0.0, description="silent so long; 0: never")

    def problems(self) -> Iterator[str]:
        if self.dot_s is not None and "mark_m" in self.model_fields_set:
            yield "dot_s: mark_m defines it too; remove one of the two"
        if self.dot_s is not None and self.dot_s * morse_dots(self.letter) > MAX_ANSWER:
            most = MAX_ANSWER / morse_dots(self.letter)
            yield f"dot_s: {self.dot_s:g} makes an answer longer than {MAX_ANSWER * 1e6:g} us; give at most {most:.2g}"
        for key, mode in (("sweep_s", "sweep"), ("tuning_error_hz", "agile")):
            if key in self.model_fields_set and self.mode != mode:
                yield f'{key}: this key is of mode = "{mode}"; give that mode or remove {key}'
        if "on_s" in self.model_fields_set and self.off_s == 0.0:
            yield "on_s: it is never silent; add off_s above 0 or remove on_s"


class SartModel(BeaconSection):
    """A search and rescue radar transponder: 12 cycles of sweeps over 9.2 to 9.5 GHz (ITU-R M.628)."""

    start_s: Instant = Field(0.0, description="when it is switched on")
    end_s: Instant | None = Field(None, description="when it is switched off; default: never")
    delay_s: Number = Field(0.5e-6, ge=0, le=1e-4, description="from the leading edge of a pulse to the answer")
    power_dbm: Number = Field(26.0, ge=-60, le=90, description="equivalent isotropic radiated power")

    def problems(self) -> Iterator[str]:
        if self.end_s is not None and self.end_s <= self.start_s:
            yield f"end_s: {self.end_s:g} is not after start_s {self.start_s:g}; exchange or remove them"


def _racon(model: RaconModel, mesh: Mesh | None) -> Racon:
    dot = 2.0 * model.mark_m / SPEED_OF_LIGHT / morse_dots(model.letter) if model.dot_s is None else model.dot_s
    sweep = model.sweep_s if model.mode == "sweep" else None
    offset, bands = _offset(model, mesh), BANDS[model.band]
    return record_of(Racon, model, offset=offset, letters=model.letter, dot=dot, bands=bands, sweep=sweep)


def _offset(model: BeaconSection, mesh: Mesh | None) -> tuple[float, float, float]:
    """Where the antenna is in the body's frame [m]; by default above the highest point of its mesh, or at a point."""
    if model.offset_m is not None:
        return model.offset_m
    if mesh is None:
        return 0.0, 0.0, 0.0
    vertices = mesh.used_vertices
    east, north, up = vertices[vertices[:, 2].argmax()].tolist()
    return east, north, up + ABOVE


class BeaconEffect(Effect):
    """Racons and SARTs."""

    name = "beacon"
    stage_at = "radar_service.stages.beacons.stage:BeaconStage"
    body_keys = {
        "racon": (RaconModel | None, Field(None, description="it answers radars by a letter in Morse code")),
        "sart": (SartModel | None, Field(None, description="it answers X-band radars by sweeps, in distress")),
    }
    sources = (Source("racon", number=5), Source("sart", number=6))
    crossing_record = BeaconTruth

    def check_body(self, given: Mapping[str, Any], is_land: bool) -> None:
        keys = [key for key in given if given[key] is not None]
        if len(keys) > 1:
            raise ValueError(
                "sart: a body has one beacon, and this one has a racon; give it to another body at the same place"
            )
        if keys and is_land:
            raise ValueError(f"{keys[0]}: a height map is land; give the beacon to a body that stands on it")

    def body_record(self, given: Mapping[str, Any], mesh: Mesh | None) -> Beacon | None:
        racon, sart = given["racon"], given["sart"]
        if racon is not None:
            return _racon(racon, mesh)
        return None if sart is None else record_of(Sart, sart, offset=_offset(sart, mesh))

    def warnings(self, scene: "Scene") -> Sequence[str]:
        beacons = [(k, body) for k, body in enumerate(scene.world.bodies) if self.name in body.effects]
        texts = [_beacon_warning(body, body.effects[self.name], k, scene.radars) for k, body in beacons]
        return [text for text in texts if text]

    def body_text(self, body: Body, radar: Radar) -> str:
        beacon: Beacon = body.effects[self.name]
        if not beacon.receives(radar.frequency, radar.pulse):
            return f"{beacon.kind}: not triggered by this radar, whose carrier or pulse it does not take"
        what = f"{SART_CYCLES} cycles of sweeps, dots {DOT_SPACING:.0f} m apart"
        if isinstance(beacon, Racon):
            carrier = "agile" if beacon.sweep is None else f"one sweep in {beacon.sweep:g} s"
            silent = f", {beacon.on:g} s on and {beacon.off:g} s off" if beacon.off else ""
            what = f'"{beacon.letters}", dots of {beacon.dot * SPEED_OF_LIGHT / 2.0:.0f} m, {carrier}{silent}'
        return f"{beacon.kind}: {what}; triggered within {beacon.triggering_range(radar) / 1000.0:.3g} km in free space"

    def sources_of(self, scene: "Scene") -> Sequence[Source]:
        kinds = {beacon.kind for beacon in self.of_bodies(scene).values()}
        return [source for source in self.sources if source.name in kinds]


def _beacon_warning(body: Body, beacon: Beacon, key: int, installations: Sequence[Installation]) -> str:
    location = f"body[{key}].{beacon.kind}"
    reaches = [max(beacon.triggering_range(radar) for radar in each.radar.of_each_pulse) for each in installations]
    if max(reaches) == 0.0:
        return f"{location}: {body.name} answers no radar of this scene, {_taken(beacon)}; {_remedy(beacon, installations)}"
    if not body.motion.at_rest or not all(each.platform.motion.at_rest for each in installations):
        return ""
    antennas = (each.platform.antenna(0.0, each.radar.height)[0] for each in installations)
    distances = [float(np.linalg.norm(body.motion.position[0] - antenna)) for antenna in antennas]
    distance, reach = min(zip(distances, reaches, strict=True), key=lambda pair: pair[0] / max(pair[1], 1e-9))
    if distance <= MAX_MULTIPATH * reach:
        return ""
    return (
        f"{location}: {body.name} is {distance / 1000.0:.3g} km off, but the peak power of the radar's pulses triggers it "
        f"within {reach / 1000.0:.3g} km in free space; raise power_w of the radar or lower sensitivity_dbm"
    )


def _taken(beacon: Beacon) -> str:
    bands = " or ".join(f"{low / 1e9:.4g} to {high / 1e9:.4g} GHz" for low, high in beacon.listens)
    return f"for it takes {bands}" + ("" if beacon.max_pulse is None else f" and pulses up to {beacon.max_pulse:g} s")


def _remedy(beacon: Beacon, installations: Sequence[Installation]) -> str:
    if any(low <= each.radar.frequency <= high for each in installations for low, high in beacon.listens):
        return "raise max_pulse_s or shorten the radar's pulse"
    return "give the radar such a frequency_hz" + ("" if isinstance(beacon, Sart) else ' or the racon band = "both"')
