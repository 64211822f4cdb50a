"""Reads the motion of a body from a track file in CSV."""

import csv
import io
import math

import numpy as np

from radar_service.numerics import MAX_COORDINATE, Floats
from radar_service.world import Motion, Origin, SceneError, map_from_geographic, segment_headings

MAX_TRACK_BYTES = 50 * 2**20
MAX_TRACK_ROWS = 1_000_000
POSITION_COLUMNS = (("east_m", "north_m"), ("latitude_deg", "longitude_deg"))
OPTIONAL_COLUMNS = ("up_m", "heading_deg")


def motion_from_track(content: bytes, location: str, heading_deg: float | None, origin: Origin | None) -> Motion:
    """Returns the motion in a track: time_s; east_m, north_m or latitude_deg, longitude_deg; optional up_m, heading_deg.

    Before the first and after the last row the body is at rest. With a heading column the heading is interpolated between
    rows; otherwise it is `heading_deg`, or the course of each leg if that is None. Raises SceneError with the line.
    """
    columns, lines = _columns(content, location)
    time = columns["time_s"]
    not_rising = np.flatnonzero(np.diff(time) <= 0.0)
    if not_rising.size:
        k = int(not_rising[0])
        raise SceneError(
            f"{location}, line {lines[k + 1]}: time_s {time[k + 1]:g} is not above {time[k]:g} of the row before; "
            "times rise strictly: sort the rows and remove duplicates"
        )
    position = np.column_stack([_positions(columns, lines, location, origin), columns.get("up_m", np.zeros(len(time)))])
    far = np.flatnonzero(~(np.abs(position).max(axis=1) <= MAX_COORDINATE))
    if far.size:
        raise SceneError(
            f"{location}, line {lines[int(far[0])]}: {position[far[0]].tolist()} m is too far from the origin; at most "
            f"{MAX_COORDINATE:g} m are allowed: move the origin or cut the track"
        )
    if "heading_deg" in columns:
        return Motion(time, position, np.deg2rad(columns["heading_deg"]), turning=True)
    return Motion(time, position, segment_headings(position, heading_deg))


def _columns(content: bytes, location: str) -> tuple[dict[str, Floats], list[int]]:
    """Returns the columns of the CSV by name, all finite, and the line on which each row ends."""
    try:
        reader = csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""))
        rows = [(reader.line_num, row) for row in reader if any(map(str.strip, row))]
    except (UnicodeDecodeError, csv.Error) as error:
        raise SceneError(f"{location}: the file is not CSV in UTF-8 ({error}); save it as comma-separated text") from None
    names = [name.strip() for name in rows[0][1]] if rows else []
    _check_names(names, location)
    if not 1 <= len(rows) - 1 <= MAX_TRACK_ROWS:
        raise SceneError(
            f"{location}: the track has {max(len(rows) - 1, 0)} rows of data; 1 to {MAX_TRACK_ROWS} are allowed: change "
            "their number"
        )
    table = np.array([_numbers(row, names, f"{location}, line {line}") for line, row in rows[1:]])
    return {name: table[:, k] for k, name in enumerate(names)}, [line for line, _ in rows[1:]]


def _check_names(names: list[str], location: str) -> None:
    """Raises SceneError unless the header has time_s, one pair of position columns, and no unknown or duplicate name."""
    pairs = [pair for pair in POSITION_COLUMNS if any(name in names for name in pair)]
    known = {"time_s", *OPTIONAL_COLUMNS, *(name for pair in pairs for name in pair)}
    complete = "time_s" in names and len(pairs) == 1 and all(name in names for name in pairs[0])
    if not complete or set(names) - known or len(set(names)) != len(names):
        raise SceneError(
            f"{location}: the first line has the columns {', '.join(names)[:200] or '(none)'}; a track needs time_s and "
            "either east_m, north_m or latitude_deg, longitude_deg, and may have up_m, heading_deg: correct the names"
        )


def _numbers(row: list[str], names: list[str], location: str) -> list[float]:
    if len(row) != len(names):
        raise SceneError(f"{location}: the row has {len(row)} values for {len(names)} columns; give one for each")
    values = []
    for text, name in zip(row, names, strict=True):
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise SceneError(f'{location}: {name} is "{text:.40}"; a finite number is needed: correct the row')
        values.append(value)
    return values


def _positions(columns: dict[str, Floats], lines: list[int], location: str, origin: Origin | None) -> Floats:
    """Returns east and north (M, 2) [m]."""
    if "east_m" in columns:
        return np.column_stack([columns["east_m"], columns["north_m"]])
    if origin is None:
        raise SceneError(f"{location}: latitude and longitude need an [origin] in the scene; add one")
    latitude, longitude = columns["latitude_deg"], columns["longitude_deg"]
    invalid = np.flatnonzero((np.abs(latitude) > 90.0) | (np.abs(longitude) > 180.0))
    if invalid.size:
        k = int(invalid[0])
        raise SceneError(
            f"{location}, line {lines[k]}: latitude {latitude[k]:g}, longitude {longitude[k]:g} is not allowed; -90 to 90 and "
            "-180 to 180 degrees: correct the row"
        )
    return map_from_geographic(latitude, longitude, origin)
