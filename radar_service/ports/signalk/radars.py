"""The radars of a service as the Signal K Radar API lists them: ids, capabilities, legend, values of controls.

What a client has read of a radar never changes under its id: a scene with other spokes or ranges has a new one.
"""

import re
from collections.abc import Iterator, Mapping
from importlib import metadata
from typing import Any

from radar_service.ports.signalk.codec import LEVELS, RadarShape
from radar_service.ports.signalk.controls import CONTROLS, ranges
from radar_service.service.radio.station import Station

VERSION = "3.4.0"  # of the Radar API
BRAND, MODEL = "Emulator", "radar-service"
STRONG, MEDIUM, LOW = (
    2 * ((LEVELS - 1) // 3),
    (LEVELS - 1) // 3,
    (LEVELS - 1) // 9,
)  # as the API's reference divides a legend


class Radars:
    """The radars by their ids in the API. Belongs to the event loop."""

    def __init__(self, stations: Mapping[str, Station]) -> None:
        self._stations = stations
        self._shapes: dict[str, tuple[RadarShape, int]] = {}  # of each station, and how many shapes it has had

    def __iter__(self) -> Iterator[tuple[str, Station]]:
        """Ids and radars, sorted by id."""
        yield from sorted((self.identity(station), station) for station in self._stations.values())

    def identity(self, station: Station) -> str:
        """Returns the id of a radar, of letters, digits and hyphens."""
        shape = RadarShape.of(station.epoch.info)
        known, count = self._shapes.get(station.identity, (shape, 1))
        count += known != shape
        self._shapes[station.identity] = shape, count
        name = "sim-" + re.sub("[^A-Za-z0-9]", "-", station.identity)
        return name if count == 1 else f"{name}-v{count}"

    def station(self, identity: str) -> Station | None:
        """Returns a radar by its id."""
        return next((station for name, station in self if name == identity), None)


def listed(station: Station, address: str) -> dict[str, Any]:
    """Returns a radar as the list has it. address: of this server."""
    return {"name": station.name, "brand": BRAND, "model": MODEL, "radarIpAddress": address, "replay": False}


def capabilities(station: Station) -> dict[str, Any]:
    """Returns what a client reads once of a radar."""
    scene, shape = station.epoch.info.scene, RadarShape.of(station.epoch.info)
    offered = ranges(scene)
    return {
        "maxRange": offered[-1],
        "minRange": offered[0],
        "supportedRanges": offered,
        "spokesPerRevolution": shape.azimuths,
        "maxSpokeLength": shape.samples,
        "pixelValues": LEVELS,
        "legend": legend(),
        "hasDoppler": False,
        "hasDualRadar": False,
        "hasDualRange": False,
        "hasSparseSpokes": False,
        "noTransmitSectors": 0,
        "controls": {control.identity: control.definition(scene) for control in CONTROLS},
    }


def legend() -> dict[str, Any]:
    """Returns what each value of a sample means: nothing, and echoes from blue by green to red."""
    pixels = ["#00000000", *(_colour(value / (LEVELS - 1)) for value in range(1, LEVELS))]
    return {
        "pixels": [{"type": "normal", "color": colour} for colour in pixels],
        "pixelColors": LEVELS,
        "lowReturn": LOW,
        "mediumReturn": MEDIUM,
        "strongReturn": STRONG,
        "dopplerApproaching": None,
        "dopplerReceding": None,
        "historyStart": LEVELS,
    }


def control_values(station: Station) -> dict[str, dict[str, Any]]:
    """Returns the value of each control by its id."""
    about = {"name": station.name, "model": MODEL, "version": metadata.version("radar-service")}
    state = {**station.controls(), **about}
    return {control.identity: dict(control.read(state)) for control in CONTROLS}


def _colour(strength: float) -> str:
    """A colour for a strength from 0 to 1: blue, green at a half, red."""
    red, blue = max(0.0, 2.0 * strength - 1.0), max(0.0, 1.0 - 2.0 * strength)
    return f"#{round(255 * red):02x}{round(255 * (1.0 - red - blue)):02x}{round(255 * blue):02x}ff"
