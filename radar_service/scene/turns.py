"""Tracks with rounded corners: straight legs joined by arcs that touch both of them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.scene.error import SceneError

Floats = NDArray[np.float64]
STRAIGHT = 1e-9  # rad; a corner below it is none
ABOUT = np.pi - 0.02  # rad; a sharper one would need legs a hundred radii long


class Rounded(NamedTuple):
    """Knots (M,): time [s], position (M, 3) [m], and of what begins there (M, 3): course [rad], speed [m/s], turn rate
    [rad/s], 0 where straight. The last knot is the end."""

    time: Floats
    position: Floats
    arcs: Floats


def rounded(stops: Floats, speeds: Sequence[float], radius: float, loop: bool, place: str) -> Rounded:
    """The way through stops (S, 3) [m], no two in a row alike, with every corner cut by an arc of `radius` [m].

    speeds: (S - 1,) of the leg that leads to each stop but the first [m/s]; an arc is sailed at the speed of the leg before
    it. loop: the last stop is the first, and its corner is rounded too: the way begins in the middle of that arc. place: for
    messages. Raises SceneError where a leg is too short for its arcs, naming the greatest radius, or turns right about.
    """
    steps = np.diff(stops, axis=0)
    length, course = np.linalg.norm(steps, axis=1), np.arctan2(steps[:, 0], steps[:, 1])
    corner = (np.roll(course, -1) - course + np.pi) % (2.0 * np.pi) - np.pi  # at the end of each leg
    if not loop:
        corner[-1] = 0.0
    corner[np.abs(corner) < STRAIGHT] = 0.0
    _check(corner, length, radius, loop, place)
    cut = radius * np.tan(np.abs(corner) / 2.0)
    before = np.roll(cut, 1)
    pieces: list[tuple[float, float, float, float]] = []  # duration, course, speed, rate
    for k, speed in enumerate(speeds):
        straight = length[k] - before[k] - cut[k]
        pieces.append((straight / speed, course[k], speed, 0.0))
        if corner[k]:
            rate = speed / radius * np.sign(corner[k])
            pieces.append((corner[k] / rate, course[k], speed, rate))
    start = stops[0].copy()
    if loop and corner[-1]:
        duration, first, speed, rate = pieces.pop()
        pieces.insert(0, (duration / 2.0, first + corner[-1] / 2.0, speed, rate))
        pieces.append((duration / 2.0, first, speed, rate))
        inward = first + corner[-1] / 2.0 + np.sign(corner[-1]) * np.pi / 2.0
        off = radius * (1.0 / np.cos(corner[-1] / 2.0) - 1.0)
        start[:2] += off * np.array([np.sin(inward), np.cos(inward)])
    return _knots(start, [piece for piece in pieces if piece[0] > 0.0])


def along_arc(course: Floats, speed: Floats, rate: Floats, since: Floats) -> tuple[Floats, Floats]:
    """Way made good (K, 3) [m] and velocity (K, 3) [m/s] `since` (K,) [s] the start of arcs; shapes (K,), rate not 0."""
    now = course + rate * since
    radius, up = speed / rate, np.zeros(len(now))
    made = np.stack([radius * (np.cos(course) - np.cos(now)), radius * (np.sin(now) - np.sin(course)), up], axis=-1)
    return made, np.stack([speed * np.sin(now), speed * np.cos(now), up], axis=-1)


def _knots(start: Floats, pieces: list[tuple[float, float, float, float]]) -> Rounded:
    duration, course, speed, rate = np.array(pieces).T
    steps = np.stack([speed * duration * np.sin(course), speed * duration * np.cos(course), 0.0 * course], axis=-1)
    bent = rate != 0.0
    steps[bent] = along_arc(course[bent], speed[bent], rate[bent], duration[bent])[0]
    time = np.concatenate([[0.0], np.cumsum(duration)])
    position = np.concatenate([start[None], start + np.cumsum(steps, axis=0)])
    arcs = np.concatenate([np.array(pieces)[:, 1:], [[course[-1] + rate[-1] * duration[-1], 0.0, 0.0]]])
    return Rounded(time, position, arcs)


def _check(corner: Floats, length: Floats, radius: float, loop: bool, place: str) -> None:
    sharp = np.flatnonzero(np.abs(corner) > ABOUT)
    if len(sharp):
        raise SceneError(
            f"{place}.turn_radius_m: the track turns right about at waypoints[{sharp[0]}]; a corner of at most "
            f"{np.rad2deg(ABOUT):.0f} degrees can be rounded: add a waypoint beside it"
        )
    tangent = np.tan(np.abs(corner) / 2.0)
    needed = tangent + np.roll(tangent, 1)
    short = np.flatnonzero(radius * needed > length * (1.0 + 1e-12))
    if len(short):
        k = int(short[np.argmin((length / np.where(needed > 0.0, needed, 1.0))[short])])
        raise SceneError(
            f"{place}.turn_radius_m: {radius:g} m is too wide for the leg of {length[k]:.1f} m to waypoints[{k}]; at most "
            f"{length[k] / needed[k]:.1f} m fits there: lower it or move the waypoints apart"
        )
