"""Builds the tidal streams of a scene from their models."""

import math
from collections.abc import Sequence

import numpy as np

from radar_service.numerics.constants import KNOT
from radar_service.numerics.types import Floats
from radar_service.scene_file.model.current import CurrentModel
from radar_service.scene_file.model.environment import EnvironmentModel
from radar_service.world.currents import CurrentArea, Currents
from radar_service.world.error import SceneError
from radar_service.world.geo import Origin, map_from_geographic
from radar_service.world.stream import NO_STREAM, Stream


def currents_from_models(environment: EnvironmentModel, areas: Sequence[CurrentModel], origin: Origin | None) -> Currents:
    """Returns all streams of a scene. Raises SceneError where an area is not one, or is narrower than its border."""
    return Currents(
        stream_from_model(environment), tuple(_area(model, f"current[{k}]", origin) for k, model in enumerate(areas))
    )


def stream_from_model(model: EnvironmentModel) -> Stream:
    """Returns the velocity of the water over ground that is the same everywhere, east and north [m/s]."""
    return NO_STREAM if model.current_to_deg is None else _stream(model.current_kn, model.current_to_deg)


def _stream(speed_kn: float, to_deg: float) -> Stream:
    to, speed = math.radians(to_deg), speed_kn * KNOT
    return speed * math.sin(to), speed * math.cos(to)


def _area(model: CurrentModel, location: str, origin: Origin | None) -> CurrentArea:
    corners = tuple((float(east), float(north)) for east, north in _corners(model, origin))
    key = "radius_m" if model.radius_m else "corners_m" if model.corners_m else "corners_deg"
    if crossing := _crossing_edges(np.array(corners)):
        raise SceneError(
            f"{location}.{key}: edges {crossing[0]} and {crossing[1]} cross; give the corners in order round the area"
        )
    stream = _stream(model.current_kn, model.current_to_deg)
    area = CurrentArea(stream, model.border_m, corners, model.radius_m or 0.0)
    if area.border > 2.0 * area.deepest:
        raise SceneError(
            f"{location}.border_m: {area.border:g} m is too wide for this area, where the stream would never be the full one; "
            f"give at most {2.0 * area.deepest:.4g} m, or a larger area"
        )
    return area


def _corners(model: CurrentModel, origin: Origin | None) -> Sequence[Sequence[float]]:
    """Corners of a polygon, or the centre of a circle alone: east and north [m]."""
    if model.corners_m is not None:
        return model.corners_m
    if model.position_m is not None:
        return [model.position_m]
    assert origin is not None, "the model of the scene checks it"
    degrees = np.array([(model.latitude_deg, model.longitude_deg)] if model.corners_deg is None else model.corners_deg)
    return [(east, north) for east, north in map_from_geographic(degrees[:, 0], degrees[:, 1], origin).tolist()]


def _crossing_edges(corners: Floats) -> tuple[int, int] | None:
    """The numbers of two edges of a polygon (E, 2) that have a point in common which is no end of both; None: there are none."""
    begin, end = corners, np.roll(corners, -1, axis=0)
    for k in range(len(corners)):
        other = np.arange(k + 2, len(corners) - (k == 0))
        ends = [_side(begin[k], end[k], each[other]) for each in (begin, end)]
        own = [_side(begin[other], end[other], each[k]) for each in (begin, end)]
        crosses = other[(ends[0] * ends[1] < 0.0) & (own[0] * own[1] < 0.0)]
        if len(crosses):
            return k, int(crosses[0])
    return None


def _side(begin: Floats, end: Floats, point: Floats) -> Floats:
    """Above 0 for points (..., 2) to the left of the way from `begin` to `end`."""
    along, offset = end - begin, point - begin
    return np.asarray(along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0])
