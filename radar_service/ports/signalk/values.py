"""The values of the Signal K stream by their paths: controls of radars, own ship, and ships with AIS.

Targets are the truth: nothing was measured, and no error of a sensor is in them. A body keeps its number in the scene.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

from radar_service.ports.ais.transponders import AisReport
from radar_service.ports.nmea.own_ship import OwnShipReport
from radar_service.ports.nmea.targets import MARK, closest_approach, true_angles
from radar_service.ports.signalk.radars import Radars, control_values
from radar_service.ports.signalk.subscriptions import SELF, Path
from radar_service.records import BodyTruth, Truth
from radar_service.world import Origin

MAX_TARGETS = 500  # of a radar: each is told each second


def targets_of(truth: Truth, origin: Origin | None = None) -> dict[int, dict[str, Any]]:
    """Returns the bodies in sight as targets by their numbers, of the first MAX_TARGETS bodies.

    Bearings and courses count from true north at own ship and at the body; without an origin from the map's.
    """
    bodies = enumerate(truth.bodies[:MAX_TARGETS], 1)
    return {number: _target(number, body, truth.own_ship, origin) for number, body in bodies if body.visible}


def target_path(radar: str, number: int) -> Path:
    """Returns the path of a target of a radar. radar: its id in the API."""
    return SELF, f"radars.{radar}.targets.{number}"


def _target(number: int, body: BodyTruth, own: BodyTruth, origin: Origin | None) -> dict[str, Any]:
    distance, time = closest_approach(body, own)
    azimuth, course = true_angles(body, own, origin)
    position: dict[str, Any] = {"bearing": azimuth % (2.0 * math.pi), "distance": round(body.range)}
    if body.latitude_deg is not None and body.longitude_deg is not None:
        position |= {"latitude": body.latitude_deg, "longitude": body.longitude_deg}
    target = {
        "id": number,
        "name": f"{MARK} {body.name}",
        "status": "tracking",
        "acquisition": "auto",
        "position": position,
        "motion": {"course": course % (2.0 * math.pi), "speed": body.speed},
    }
    return (
        target if time is None else target | {"danger": {"cpa": distance, "tcpa": time}}
    )  # how near is too near, the client decides


class Values:
    """All that can be subscribed to, with the time of each value. Belongs to the event loop.

    changed: is called with each path whose value is another one.
    """

    def __init__(self, changed: Callable[[Path], None], timestamp: Callable[[], str]) -> None:
        """timestamp: returns the present time of the world, as text."""
        self._changed, self._timestamp = changed, timestamp
        self._values: dict[Path, Any] = {}
        self._times: dict[Path, str] = {}

    def __getitem__(self, path: Path) -> Any:
        """Returns the value of a path."""
        return self._values[path]

    def __contains__(self, path: object) -> bool:
        """Returns whether there is such a path."""
        return path in self._values

    @property
    def paths(self) -> list[Path]:
        """All paths that have a value, in the order in which they came."""
        return [path for path, value in self._values.items() if value is not None]

    def time(self, path: Path) -> str:
        """Returns when the value of a path was taken."""
        return self._times[path]

    def put(self, values: Mapping[Path, Any], unchanged_too: bool = False) -> None:
        """Takes the values of some paths. unchanged_too: whether those that have not changed are told too."""
        timestamp = self._timestamp()
        for path, value in values.items():
            self._times[path] = timestamp
            if unchanged_too or path not in self._values or self._values[path] != value:
                self._values[path] = value
                self._changed(path)

    def put_targets(self, radar: str, targets: Mapping[int, Any]) -> None:
        """Takes the targets of a radar, by its id in the API; those that it has no more become null."""
        present = {target_path(radar, number): target for number, target in targets.items()}
        self.put(dict.fromkeys(self._of_targets(radar)) | present)

    def targets(self, radar: str) -> list[Any]:
        """Returns the targets of a radar, by its id in the API."""
        return [self._values[path] for path in self._of_targets(radar)]

    def _of_targets(self, radar: str) -> list[Path]:
        beginning = target_path(radar, 0)[1][:-1]
        return [path for path in self.paths if path[1].startswith(beginning)]

    def keep_radars(self, radars: Radars) -> None:
        """Forgets radars whose ids are no more, and takes the values of all others."""
        for path in list(self._values):
            if path[1].startswith("radars.") and path[1].split(".")[1] not in dict(radars):
                del self._values[path]
        for identity, station in radars:
            controls = control_values(station).items()
            self.put({(SELF, f"radars.{identity}.controls.{name}"): value for name, value in controls})


def own_ship_values(own: OwnShipReport) -> dict[Path, Any]:
    """Returns own ship as its sensors report it; what is not known is left out."""
    known = {"headingTrue": own.heading, "courseOverGroundTrue": own.course, "speedOverGround": own.speed}
    position = None if own.position is None else dict(zip(("latitude", "longitude"), own.position, strict=True))
    return _navigation(SELF, known | {"position": position})


def vessel_values(report: AisReport) -> dict[Path, Any]:
    """Returns what a transponder reports, by paths of a context of its own; what is not known is left out."""
    at, is_aid = report.position, report.ship.kind == "aid"
    context = f"{'atons' if is_aid else 'vessels'}.urn:mrn:imo:mmsi:{report.ship.mmsi:09d}"
    values: dict[Path, Any] = {}
    if is_aid or (report.static and report.ship.kind == "ship"):
        values[context, ""] = {"name": report.ship.name, "mmsi": f"{report.ship.mmsi:09d}"}
    if at is not None:
        known: dict[str, Any] = {"headingTrue": at.heading, "courseOverGroundTrue": at.course, "speedOverGround": at.speed}
        known = {} if is_aid else known
        if at.latitude is not None and at.longitude is not None:
            known["position"] = {"latitude": at.latitude, "longitude": at.longitude}
        values |= _navigation(context, known)
    return values


def _navigation(context: str, known: Mapping[str, Any]) -> dict[Path, Any]:
    return {(context, f"navigation.{name}"): value for name, value in known.items() if value is not None}
