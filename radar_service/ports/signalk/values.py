"""The values of the Signal K stream by their paths: controls of radars, and own ship. Belongs to the event loop."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from radar_service.ports.signalk.radars import Radars, control_values
from radar_service.ports.signalk.subscriptions import SELF, Path
from radar_service.records.spokes import SpokeBlock
from radar_service.service.radio.station import Station
from radar_service.service.spokes import RadarInfo, SpokeBatch
from radar_service.world.geo import Origin, geographic_from_map

OWN_SHIP_PERIOD = 0.1  # s of simulation between two states of own ship


class Values:
    """All that can be subscribed to. changed: is called with each path whose value is another one."""

    def __init__(self, changed: Callable[[Path], None]) -> None:
        self._changed = changed
        self._values: dict[Path, Any] = {}

    def __getitem__(self, path: Path) -> Any:
        """Returns the value of a path."""
        return self._values[path]

    def __contains__(self, path: object) -> bool:
        """Returns whether there is such a path."""
        return path in self._values

    @property
    def paths(self) -> list[Path]:
        """All paths, in the order in which they came."""
        return list(self._values)

    def put(self, values: Mapping[Path, Any]) -> None:
        """Takes the values of some paths."""
        for path, value in values.items():
            if path not in self._values or self._values[path] != value:
                self._values[path] = value
                self._changed(path)

    def keep_radars(self, radars: Radars) -> None:
        """Forgets radars whose ids are no more, and takes the values of all others."""
        for path in self.paths:
            if path[1].startswith("radars.") and path[1].split(".")[1] not in dict(radars):
                del self._values[path]
        for identity, station in radars:
            self.put(radar_values(identity, station))


def control_path(identity: str, control: str) -> Path:
    """Returns the path of a control of a radar."""
    return SELF, f"radars.{identity}.controls.{control}"


def radar_values(identity: str, station: Station) -> dict[Path, Any]:
    """Returns the values of a radar's controls by their paths."""
    return {control_path(identity, name): value for name, value in control_values(station).items()}


def own_ship_values(block: SpokeBlock, origin: Origin | None) -> dict[Path, Any]:
    """Returns own ship as she is reported with the last spoke of a block; what is not known is left out."""
    heading, course, speed = (float(column[-1]) for column in (block.heading, block.course, block.speed))
    values: dict[Path, Any] = {
        (SELF, f"navigation.{name}"): value % (2.0 * math.pi) if name != "speedOverGround" else value
        for name, value in (("headingTrue", heading), ("courseOverGroundTrue", course), ("speedOverGround", speed))
        if math.isfinite(value)
    }
    if origin is not None:
        latitude, longitude = map(float, geographic_from_map(block.position[-1], origin))
        values[SELF, "navigation.position"] = {"latitude": latitude, "longitude": longitude}
    return values


class OwnShipSink:
    """A sink that tells how own ship is reported, each OWN_SHIP_PERIOD of simulated time. tell: takes the values."""

    def __init__(self, tell: Callable[[Mapping[Path, Any]], None]) -> None:
        self._tell, self._last = tell, -math.inf

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins anew."""
        self._last = -math.inf

    def send(self, batch: SpokeBatch) -> None:
        """Tells of the last spoke, where its time has come."""
        time = float(batch.block.time[-1])
        if time >= self._last + OWN_SHIP_PERIOD:
            self._last = time
            self._tell(own_ship_values(batch.block, batch.epoch.info.scene.origin))

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Tells nothing."""

    def close(self, reason: str) -> None:
        """Tells nothing."""
