"""How bodies and own ship move: `world.Motion` from a constant course and speed, from waypoints, or from a track file."""

import csv
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from radar_service.constants import KNOT
from radar_service.scene.error import SceneError
from radar_service.scene.geo import Origin, map_from_geographic
from radar_service.scene.model import MovingSection, OwnShipModel, WaypointModel
from radar_service.scene.turns import Rounded, rounded
from radar_service.scene.world import Motion, Sway

Floats = NDArray[np.float64]

MAX_TRACK_BYTES = 50 * 2**20
MAX_TRACK_ROWS = 1_000_000
REACH = 2e6  # m, as for any coordinate of a scene
PLACES = {"map": ("east_m", "north_m"), "earth": ("latitude_deg", "longitude_deg")}
EXTRA = ("up_m", "heading_deg")


def motion_from_model(
    section: MovingSection, start: Floats, place: str, read: Callable[[str, str], bytes], origin: Origin | None
) -> Motion:
    """The motion of a body or of own ship that begins at `start` (3,) [m].

    place: where the section stands in the scene, for messages; read: (file name, place) -> content of a file of the scene's
    folder. Raises SceneError where a track is not usable.
    """
    motion = _way(section, start, place, read, origin)
    return replace(motion, sway=sway_from_model(section)) if isinstance(section, OwnShipModel) else motion


def sway_from_model(section: OwnShipModel) -> Sway | None:
    """The sway of own ship, None where she has none."""
    amplitude = np.deg2rad([section.roll_deg, section.pitch_deg, section.yaw_deg])
    period = np.array([section.roll_period_s, section.pitch_period_s, section.yaw_period_s])
    return Sway(amplitude, period) if amplitude.any() else None


def _way(
    section: MovingSection, start: Floats, place: str, read: Callable[[str, str], bytes], origin: Origin | None
) -> Motion:
    if section.track is not None:
        where = f"{place}.track" if place else "track"
        return motion_from_track(read(section.track, where), f"{where}: {section.track}", section.heading_deg, origin)
    if section.waypoints:
        return motion_from_waypoints(
            section.waypoints, start, section.heading_deg, section.loop, section.turn_radius_m, place
        )
    return constant_motion(start, section.heading_deg, section.course_deg, section.speed_kn * KNOT)


def constant_motion(start: Floats, heading_deg: float | None, course_deg: float | None, speed: float) -> Motion:
    """A straight course at one speed [m/s] for ever; the heading is the course where not given, and the reverse."""
    course = math.radians(_first(course_deg, heading_deg, 0.0))
    heading = math.radians(_first(heading_deg, course_deg, 0.0))
    velocity = speed * np.array([math.sin(course), math.cos(course), 0.0])
    return Motion(np.zeros(1), start.reshape(1, 3), np.array([heading]), velocity)


def _first(*values: float | None) -> float:
    return next(value for value in values if value is not None)


def motion_from_waypoints(
    waypoints: Sequence[WaypointModel],
    start: Floats,
    heading_deg: float | None,
    loop: bool,
    radius: float | None = None,
    place: str = "",
) -> Motion:
    """From `start` through the waypoints, each at the speed of the leg that leads there; then it stops, or returns to the
    start at the last speed and goes round for ever.

    A waypoint where the body already is makes no leg. The heading follows the leg unless `heading_deg` is given. radius: of
    the arcs that cut the corners [m], None for sharp ones; place: for messages. Raises SceneError where arcs do not fit.
    """
    stops = [(*waypoint.position_m, start[2]) for waypoint in waypoints]
    speeds = [waypoint.speed_kn * KNOT for waypoint in waypoints]
    if loop:
        stops, speeds = [*stops, (start[0], start[1], start[2])], [*speeds, speeds[-1]]
    times, places, sailed = [0.0], [start], []
    for stop, speed in zip(stops, speeds, strict=True):
        here = np.array(stop)
        duration = float(np.linalg.norm(here - places[-1])) / speed
        if times[-1] + duration > times[-1]:
            times.append(times[-1] + duration)
            places.append(here)
            sailed.append(speed)
    if radius is not None and sailed:
        return _rounded_motion(rounded(np.array(places), sailed, radius, loop, place), heading_deg, loop)
    position = np.array(places)
    heading = _leg_headings(position, heading_deg)
    period = times[-1] if loop and times[-1] > 0.0 else None
    return Motion(np.array(times), position, heading, period=period)


def _rounded_motion(way: Rounded, heading_deg: float | None, loop: bool) -> Motion:
    fixed = heading_deg is not None
    heading = np.full(len(way.time), math.radians(heading_deg)) if heading_deg is not None else way.arcs[:, 0]
    period = float(way.time[-1]) if loop else None
    return Motion(way.time, way.position, heading, period=period, arcs=way.arcs, fixed=fixed)


def _leg_headings(position: Floats, heading_deg: float | None) -> Floats:
    """(M,) the course of the leg that begins at each knot [rad]; a stand keeps the last course, the first one the next."""
    if heading_deg is not None:
        return np.full(len(position), math.radians(heading_deg))
    steps = np.diff(position[:, :2], axis=0)
    moving = np.flatnonzero(np.hypot(steps[:, 0], steps[:, 1]) > 0.0)
    if moving.size == 0:
        return np.zeros(len(position))
    course = np.arctan2(steps[moving, 0], steps[moving, 1])
    latest = np.searchsorted(moving, np.arange(len(position)), side="right") - 1
    headings: Floats = course[np.maximum(latest, 0)]
    return headings


def motion_from_track(content: bytes, place: str, heading_deg: float | None, origin: Origin | None) -> Motion:
    """A track from CSV: time_s; east_m, north_m or latitude_deg, longitude_deg; optional up_m, heading_deg.

    Before the first and after the last row the body stands still. With a heading column it turns evenly from row to row,
    else it heads along each leg. Raises SceneError naming the line.
    """
    columns, lines = _columns(content, place)
    time = columns["time_s"]
    falling = np.flatnonzero(np.diff(time) <= 0.0)
    if falling.size:
        k = int(falling[0])
        raise SceneError(
            f"{place}, line {lines[k + 1]}: time_s {time[k + 1]:g} does not rise above {time[k]:g} of the row before; "
            "times rise strictly: sort the rows and remove doubles"
        )
    position = np.column_stack([_places(columns, lines, place, origin), columns.get("up_m", np.zeros(len(time)))])
    far = np.flatnonzero(~(np.abs(position).max(axis=1) <= REACH))
    if far.size:
        raise SceneError(
            f"{place}, line {lines[int(far[0])]}: {position[far[0]].tolist()} m is farther than {REACH:g} m from the "
            "origin, where the flat map ends: move the origin or cut the track"
        )
    if "heading_deg" in columns:
        return Motion(time, position, np.deg2rad(columns["heading_deg"]), turning=True)
    return Motion(time, position, _leg_headings(position, heading_deg))


def _columns(content: bytes, place: str) -> tuple[dict[str, Floats], list[int]]:
    """The columns of the CSV by name, all finite, and the line that each row ends on."""
    try:
        reader = csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""))
        rows = [(reader.line_num, row) for row in reader if any(map(str.strip, row))]
    except (UnicodeDecodeError, csv.Error) as fault:
        raise SceneError(f"{place}: not a CSV file in UTF-8 ({fault}); save it as comma-separated text") from None
    names = [name.strip() for name in rows[0][1]] if rows else []
    _check_names(names, place)
    if not 1 <= len(rows) - 1 <= MAX_TRACK_ROWS:
        raise SceneError(f"{place}: {max(len(rows) - 1, 0)} rows of data; a track has 1 to {MAX_TRACK_ROWS}")
    table = np.array([_numbers(row, names, f"{place}, line {line}") for line, row in rows[1:]])
    return {name: table[:, k] for k, name in enumerate(names)}, [line for line, _ in rows[1:]]


def _check_names(names: list[str], place: str) -> None:
    """Raises SceneError unless the header is time_s, one pair of places, and nothing unknown or double."""
    pairs = [pair for pair in PLACES.values() if any(name in names for name in pair)]
    known = {"time_s", *EXTRA, *(name for pair in pairs for name in pair)}
    right = "time_s" in names and len(pairs) == 1 and all(name in names for name in pairs[0])
    if not right or set(names) - known or len(set(names)) != len(names):
        raise SceneError(
            f"{place}: the first line names the columns {', '.join(names)[:200] or '(none)'}; needed are time_s and "
            "either east_m, north_m or latitude_deg, longitude_deg; allowed are up_m, heading_deg: name the columns there"
        )


def _numbers(row: list[str], names: list[str], place: str) -> list[float]:
    if len(row) != len(names):
        raise SceneError(f"{place}: {len(row)} values for {len(names)} columns; give one for each")
    values = []
    for text, name in zip(row, names, strict=True):
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise SceneError(f'{place}: {name} is "{text:.40}"; a finite number is needed: correct the row')
        values.append(value)
    return values


def _places(columns: dict[str, Floats], lines: list[int], place: str, origin: Origin | None) -> Floats:
    """(M, 2) east and north [m]."""
    if "east_m" in columns:
        return np.column_stack([columns["east_m"], columns["north_m"]])
    if origin is None:
        raise SceneError(f"{place}: latitude and longitude need an [origin] in the scene; add one")
    latitude, longitude = columns["latitude_deg"], columns["longitude_deg"]
    wild = np.flatnonzero((np.abs(latitude) > 90.0) | (np.abs(longitude) > 180.0))
    if wild.size:
        k = int(wild[0])
        raise SceneError(
            f"{place}, line {lines[k]}: latitude {latitude[k]:g}, longitude {longitude[k]:g}; latitudes run from -90 to 90, "
            "longitudes from -180 to 180 degrees: correct the row"
        )
    return map_from_geographic(latitude, longitude, origin)
