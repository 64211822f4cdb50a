"""Beacons as an effect: their keys, what `check` says of them, and warnings of those that no radar of a scene triggers."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.radar.parameters import Radar
from radar_service.stages.beacons.beacon import DOT_SPACING, SART_CYCLES, Beacon, BeaconTruth, Racon, Sart
from radar_service.stages.beacons.keys import RaconModel, SartModel, beacon_from_models
from radar_service.stages.effect import Effect, Source
from radar_service.world.body import Body, Mesh
from radar_service.world.platform import Installation

if TYPE_CHECKING:
    from radar_service.world.scene import Scene

MAX_MULTIPATH = 2.0  # of the field, direct and reflected ray in phase: a pulse triggers as much farther


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
        return beacon_from_models(given["racon"], given["sart"], mesh)

    def warnings(self, scene: "Scene") -> Sequence[str]:
        beacons = [
            (k, body, body.effects[self.name]) for k, body in enumerate(scene.world.bodies) if self.name in body.effects
        ]
        texts = [_beacon_warning(body, beacon, f"body[{k}].{beacon.kind}", scene.radars) for k, body, beacon in beacons]
        return [text for text in texts if text]

    def body_text(self, body: Body, radar: Radar) -> str:
        return _beacon_text(body.effects[self.name], radar)

    def sources_of(self, scene: "Scene") -> Sequence[Source]:
        kinds = {beacon.kind for beacon in self.of_bodies(scene).values()}
        return [source for source in self.sources if source.name in kinds]


def _beacon_warning(body: Body, beacon: Beacon, location: str, installations: Sequence[Installation]) -> str:
    reaches = [max(beacon.triggering_range(radar) for radar in each.radar.of_each_pulse) for each in installations]
    if max(reaches) == 0.0:
        return f"{location}: {body.name} answers no radar of this scene, {_taken(beacon)}; {_remedy(beacon, installations)}"
    if not body.motion.at_rest or not all(each.platform.motion.at_rest for each in installations):
        return ""
    position = body.motion.position[0]
    distances = [
        float(np.linalg.norm(position - each.platform.antenna(0.0, each.radar.height)[0])) for each in installations
    ]
    nearest = min(zip(distances, reaches, strict=True), key=lambda pair: pair[0] / max(pair[1], 1e-9))
    if nearest[0] <= MAX_MULTIPATH * nearest[1]:
        return ""
    return (
        f"{location}: {body.name} is {nearest[0] / 1000.0:.3g} km off, but the peak power of the radar's pulses triggers it "
        f"within {nearest[1] / 1000.0:.3g} km in free space; raise power_w of the radar or lower sensitivity_dbm"
    )


def _taken(beacon: Beacon) -> str:
    bands = " or ".join(f"{low / 1e9:.4g} to {high / 1e9:.4g} GHz" for low, high in beacon.listens)
    return f"for it takes {bands}" + ("" if beacon.max_pulse is None else f" and pulses up to {beacon.max_pulse:g} s")


def _remedy(beacon: Beacon, installations: Sequence[Installation]) -> str:
    if any(low <= each.radar.frequency <= high for each in installations for low, high in beacon.listens):
        return "raise max_pulse_s or shorten the radar's pulse"
    return "give the radar such a frequency_hz" + ("" if isinstance(beacon, Sart) else ' or the racon band = "both"')


def _beacon_text(beacon: Beacon, radar: Radar) -> str:
    """What answers this radar from a body, and from how far at boresight in free space."""
    if not beacon.receives(radar.frequency, radar.pulse):
        return f"{beacon.kind}: not triggered by this radar, whose carrier or pulse it does not take"
    what = f"{SART_CYCLES} cycles of sweeps, dots {DOT_SPACING:.0f} m apart"
    if isinstance(beacon, Racon):
        carrier = "agile" if beacon.sweep is None else f"one sweep in {beacon.sweep:g} s"
        silent = f", {beacon.on:g} s on and {beacon.off:g} s off" if beacon.off else ""
        what = f'"{beacon.letters}", dots of {beacon.dot * SPEED_OF_LIGHT / 2.0:.0f} m, {carrier}{silent}'
    return f"{beacon.kind}: {what}; triggered within {beacon.triggering_range(radar) / 1000.0:.3g} km in free space"
