"""Builds the motion of a body or of own ship from a constant course and speed, from waypoints or from a track."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from radar_service.numerics import KNOT, Floats
from radar_service.scene_file.model.moving import AMPLITUDES, MovingSection, SwaySection, WaypointModel
from radar_service.stages.fields import record_of
from radar_service.world import (
    NO_STREAM,
    Knot,
    Manoeuvre,
    Motion,
    Origin,
    RoundedRoute,
    SceneError,
    SteeredMotion,
    SteeringLimits,
    Stream,
    Sway,
    in_stream,
    map_from_geographic,
    motion_with_manoeuvres,
    round_corners,
    segment_headings,
)

TrackReader = Callable[[str, str, float | None], Motion]  # file name, location, heading_deg


def motion_from_model(
    section: MovingSection, start: Floats, location: str, read_track: TrackReader, stream: Stream = NO_STREAM
) -> Motion:
    """Returns the motion of a body or of own ship that begins at `start` (3,) [m].

    location: key path of the section, for messages. read_track: returns the motion in a file of the scene's folder.
    stream: of the water, east and north [m/s], for which the heading allows unless it is given.
    Raises SceneError if a track or the corners of a route are not usable.
    """
    motion = _motion_without_sway(section, start, location, read_track)
    motion = replace(in_stream(motion, stream, section.heading_deg is not None), sway=sway_from_model(section))
    if section.steerable is None:
        return motion
    return SteeredMotion.under(motion, record_of(SteeringLimits, section.steerable), stream)


def sway_from_model(section: SwaySection) -> Sway | None:
    """Returns the sway, None if all amplitudes are 0 and the ship is upright."""
    amplitude = np.array([*np.deg2rad([section.roll_deg, section.pitch_deg, section.yaw_deg]), section.heave_m])
    period, phase = (
        np.array([getattr(section, f"{name}_{ending}") for name in AMPLITUDES]) for ending in ("period_s", "phase_deg")
    )
    lean = math.radians(section.list_deg or 0.0), math.radians(section.trim_deg or 0.0)
    return Sway(amplitude, period, np.deg2rad(phase), lean) if amplitude.any() or any(lean) else None


def _motion_without_sway(section: MovingSection, start: Floats, location: str, read_track: TrackReader) -> Motion:
    motion = _motion_without_drift(section, start, location, read_track)
    if not section.drift_deg:
        return motion
    if motion.turning:
        raise SceneError(f"{location}.drift_deg: the track has a heading_deg of its own; remove drift_deg or that column")
    return replace(motion, heading=motion.heading - math.radians(section.drift_deg))


def _motion_without_drift(section: MovingSection, start: Floats, location: str, read_track: TrackReader) -> Motion:
    if section.track is not None:
        return read_track(section.track, f"{location}.track", section.heading_deg)
    if section.waypoints:
        rate = None if section.turn_rate_deg_s is None else math.radians(section.turn_rate_deg_s)
        return motion_from_waypoints(
            section.waypoints, start, section.heading_deg, section.loop, section.turn_radius_m, location, rate
        )
    if section.turn_rate_deg_s or section.manoeuvre:
        course, rate = math.radians(section.course_deg or 0.0), math.radians(section.turn_rate_deg_s or 0.0)
        knot = Knot(0.0, start, course, section.speed_kn * KNOT, rate)
        return motion_with_manoeuvres(knot, [record_of(Manoeuvre, manoeuvre) for manoeuvre in section.manoeuvre])
    return constant_motion(start, section.heading_deg, section.course_deg, section.speed_kn * KNOT)


def constant_motion(start: Floats, heading_deg: float | None, course_deg: float | None, speed: float) -> Motion:
    """Returns motion on a straight course at constant `speed` [m/s]; heading and course default to each other, or to 0."""
    course = math.radians(_first(course_deg, heading_deg, 0.0))
    heading = math.radians(_first(heading_deg, course_deg, 0.0))
    velocity = speed * np.array([math.sin(course), math.cos(course), 0.0])
    return Motion(np.zeros(1), start.reshape(1, 3), np.array([heading]), velocity)


def start_position(
    latitude_deg: float | None,
    longitude_deg: float | None,
    up: float,
    position: Sequence[float] | None,
    origin: Origin | None,
) -> Floats:
    """Returns a position (3,) [m] that is given in degrees and a height, or on the map; by default the origin."""
    if latitude_deg is not None and longitude_deg is not None and origin is not None:
        return np.array([*map_from_geographic(latitude_deg, longitude_deg, origin), up])
    return np.array([*(position or ()), 0.0, 0.0, 0.0][:3])


def _first(*values: float | None) -> float:
    return next(value for value in values if value is not None)


def motion_from_waypoints(
    waypoints: Sequence[WaypointModel], start: Floats, heading_deg: float | None, loop: bool, radius: float | None = None,
    location: str = "", turn_rate: float | None = None,
) -> Motion:  # fmt: skip
    """Returns the motion from `start` (3,) [m] through waypoints, each leg at the speed of its end; then the body stops.

    With `loop` it returns to the start at the last speed and repeats. A waypoint at the body's position makes no leg. The
    heading follows the leg unless `heading_deg` is given. radius: of the arcs at corners [m], None for sharp corners.
    location: key path for messages. turn_rate: on the arcs, instead of a radius [rad/s]. Raises SceneError if arcs do not
    fit.
    """
    stops = [(*waypoint.position_m, start[2]) for waypoint in waypoints]
    speeds = [waypoint.speed_kn * KNOT for waypoint in waypoints]
    if loop:
        stops, speeds = [*stops, (start[0], start[1], start[2])], [*speeds, speeds[-1]]
    times, positions, segment_speeds = [0.0], [start], []
    for stop, speed in zip(stops, speeds, strict=True):
        position = np.array(stop)
        duration = float(np.linalg.norm(position - positions[-1])) / speed
        if times[-1] + duration > times[-1]:
            times.append(times[-1] + duration)
            positions.append(position)
            segment_speeds.append(speed)
    if (radius is not None or turn_rate is not None) and segment_speeds:
        radii = np.array(segment_speeds) / turn_rate if turn_rate is not None else np.full(len(segment_speeds), radius)
        key = f"{location}.{'turn_radius_m' if turn_rate is None else 'turn_rate_deg_s'}"
        return _rounded_motion(round_corners(np.array(positions), segment_speeds, radii, loop, key), heading_deg, loop)
    knots = np.array(positions)
    heading = segment_headings(knots, heading_deg)
    period = times[-1] if loop and times[-1] > 0.0 else None
    return Motion(np.array(times), knots, heading, period=period)


def _rounded_motion(route: RoundedRoute, heading_deg: float | None, loop: bool) -> Motion:
    fixed = heading_deg is not None
    heading = np.full(len(route.time), math.radians(heading_deg)) if heading_deg is not None else route.arcs[:, 0]
    period = float(route.time[-1]) if loop else None
    return Motion(route.time, route.position, heading, period=period, arcs=route.arcs, fixed=fixed)
