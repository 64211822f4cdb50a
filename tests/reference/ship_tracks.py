"""Slow reference: where bodies of a scene file are at a time, from the words of docs/scenes.md, sharing no code with the engine.

A table is that of a body or of own ship. A route is a list of parts: straight ones and arcs, each with its duration.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Table = Mapping[str, Any]
KNOT = 1852.0 / 3600.0  # m/s
PERIODS = {"roll": 10.0, "pitch": 7.0, "yaw": 20.0, "heave": 8.0}  # s, defaults of docs/scenes.md


class Part(NamedTuple):
    """duration [s], course at its begin [rad], speed [m/s], turn rate to starboard [rad/s]."""

    duration: float
    course: float
    speed: float
    rate: float = 0.0

    def after(self, time: float) -> tuple[Floats, float]:
        """Displacement (2,) east and north [m] and course [rad] after a time [s] of it."""
        course = self.course + self.rate * time
        if self.rate == 0.0:
            return self.speed * time * np.array([np.sin(course), np.cos(course)]), course
        chord = 2.0 * self.speed / self.rate * np.sin(self.rate * time / 2.0)
        middle = (self.course + course) / 2.0
        return chord * np.array([np.sin(middle), np.cos(middle)]), course


class Stand(NamedTuple):
    """Position (3,) of a body's origin [m], and the rotation (3, 3) from its own frame (x starboard, y ahead) to the map."""

    position: Floats
    rotation: Floats


def stand(table: Table, time: float, tracks: Mapping[str, Floats]) -> Stand:
    """Where a body is at a time [s], 0 or later. tracks: rows (M, 4 or 5) of each file: time [s], east, north, up [m], and
    heading [degrees]."""
    if "track" in table:
        position, heading = on_track(tracks[table["track"]], time)
    else:
        start = np.array([*table.get("position_m", (0.0, 0.0)), 0.0][:3], dtype=np.float64)
        moved, course = along(route(table), time, bool(table.get("loop", False)))
        position = start + np.array([*moved, 0.0])
        heading = course - np.deg2rad(table.get("drift_deg", 0.0))
        if "heading_deg" in table:
            heading = np.deg2rad(table["heading_deg"])
    roll, pitch, yaw = (np.deg2rad(wave(table, name, "deg", time)) for name in ("roll", "pitch", "yaw"))
    position = position + np.array([0.0, 0.0, wave(table, "heave", "m", time)])
    return Stand(position, turned_to(heading + yaw) @ bow_up(pitch) @ starboard_down(roll))


def wave(table: Table, name: str, unit: str, time: float) -> float:
    """Amplitude x sin(2 pi t / period + phase), in the unit of its key."""
    phase = np.deg2rad(table.get(f"{name}_phase_deg", 0.0))
    angle = 2.0 * np.pi * time / table.get(f"{name}_period_s", PERIODS[name]) + phase
    return float(table.get(f"{name}_{unit}", 0.0) * np.sin(angle))


def turned_to(heading: float) -> Floats:
    """The bow (y) along a heading [rad]."""
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def bow_up(angle: float) -> Floats:
    """The bow (y) raised by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def starboard_down(angle: float) -> Floats:
    """Starboard (x) lowered by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def on_track(rows: Floats, time: float) -> tuple[Floats, float]:
    """Position (3,) [m] and heading [rad] on a track, within its times; without a heading, that of the leg."""
    leg = int(np.clip(np.searchsorted(rows[:, 0], time, side="right") - 1, 0, len(rows) - 2))
    here, there = rows[leg], rows[leg + 1]
    share = (time - here[0]) / (there[0] - here[0])
    position = here[1:4] + share * (there[1:4] - here[1:4])
    if rows.shape[1] == 4:
        return position, float(np.arctan2(there[1] - here[1], there[2] - here[2]))
    turn = (there[4] - here[4] + 180.0) % 360.0 - 180.0
    return position, float(np.deg2rad(here[4] + share * turn))


def along(parts: list[Part], time: float, loop: bool) -> tuple[Floats, float]:
    """Displacement (2,) [m] and course [rad] after a time [s] on a route; after its end the body stops."""
    if loop:
        time = time % sum(part.duration for part in parts)
    moved, course = np.zeros(2), parts[0].course
    for part in parts:
        step, course = part.after(min(time, part.duration))
        moved, time = moved + step, time - part.duration
        if time < 0.0:
            break
    return moved, course


def route(table: Table) -> list[Part]:
    """The parts of a route from its start."""
    if "waypoints" in table:
        return by_waypoints(table)
    course = np.deg2rad(table.get("course_deg", table.get("heading_deg", 0.0)))
    state = Part(np.inf, course, table.get("speed_kn", 0.0) * KNOT, np.deg2rad(table.get("turn_rate_deg_s", 0.0)))
    parts, now, ends = [], 0.0, np.inf  # ends: when a turn to a new course does
    for change in table.get("manoeuvre", []):
        if ends <= change["time_s"]:
            parts.append(state._replace(duration=ends - now))
            state, now, ends = state._replace(course=state.course + state.rate * (ends - now), rate=0.0), ends, np.inf
        elapsed = change["time_s"] - now
        parts.append(state._replace(duration=elapsed))
        state, now = state._replace(course=state.course + state.rate * elapsed), change["time_s"]
        state, ends = changed(state, change, now, ends)
    if np.isfinite(ends):
        parts.append(state._replace(duration=ends - now))
        state = state._replace(course=state.course + state.rate * (ends - now), rate=0.0)
    return [*parts, state]


def changed(state: Part, change: Table, now: float, ends: float) -> tuple[Part, float]:
    """The state after a manoeuvre, and when its turn ends [s]."""
    state = state._replace(speed=change["speed_kn"] * KNOT) if "speed_kn" in change else state
    rate = np.deg2rad(change["turn_rate_deg_s"]) if "turn_rate_deg_s" in change else None
    if "course_deg" not in change:
        return (state, ends) if rate is None else (state._replace(rate=rate), np.inf)
    if rate is None:
        return state._replace(course=np.deg2rad(change["course_deg"]), rate=0.0), np.inf
    turn = np.angle(np.exp(1j * (np.deg2rad(change["course_deg"]) - state.course)))
    return state._replace(rate=float(np.copysign(rate, turn))), now + abs(turn / rate)


def by_waypoints(table: Table) -> list[Part]:
    """Straight legs, with arcs at the corners where the table rounds them; an arc has the speed of the leg before it."""
    here, legs = np.array(table["position_m"][:2], dtype=np.float64), []
    stops = [(each["position_m"], each["speed_kn"] * KNOT) for each in table["waypoints"]]
    if table.get("loop", False):
        stops.append((table["position_m"][:2], stops[-1][1]))
    for stop, speed in stops:
        step = np.array(stop, dtype=np.float64) - here
        legs.append((float(np.hypot(*step)), float(np.arctan2(step[0], step[1])), speed))
        here = here + step
    parts, cut = [], 0.0
    for (length, course, speed), after in zip(legs, [*legs[1:], None], strict=True):
        turn = 0.0 if after is None else float(np.angle(np.exp(1j * (after[1] - course))))
        radius = table.get("turn_radius_m", 0.0)
        if "turn_rate_deg_s" in table:
            radius = speed / np.deg2rad(table["turn_rate_deg_s"])
        before, cut = cut, radius * np.tan(abs(turn) / 2.0)
        parts.append(Part((length - before - cut) / speed, course, speed))
        if radius and turn:
            parts.append(Part(abs(turn) * radius / speed, course, speed, float(np.sign(turn)) * speed / radius))
    return parts
