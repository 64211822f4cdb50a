"""The truth as targets of the Signal K Radar API, for clients that have no other way to it. Each name begins with `TRUTH`.

These are no tracks of a radar: nothing was measured, and no error of a sensor is in them. A body keeps its number, that in the
scene, from 1 on.
"""

import math
from typing import Any

from radar_service.ports.nmea.targets import MARK, closest_approach, true_angles
from radar_service.ports.signalk.subscriptions import SELF, Path
from radar_service.records.truth import BodyTruth, Truth
from radar_service.world.geo import Origin

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
