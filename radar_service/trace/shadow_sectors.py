"""Which of many bodies may occlude which points: a quick test in plan, by the sector behind each body's bounding sphere."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Flags, Floats, Indices, batches, wrap_angle

PAIRS = 2**17  # of bodies and points at a time: their rays take some 20 MB
ROUNDING = 0.1  # m, of heights
TURNS = 3  # by which a sector is looked up among azimuths from -pi to pi


class ShadowSectors(NamedTuple):
    """Sectors (N,) that bodies may occlude from the antenna.

    middle, half: azimuth of the middle, and half the width [rad].
    begin: ground distance of the start [m].
    """

    middle: Floats
    half: Floats
    begin: Floats

    def of(self, bodies: Indices) -> "ShadowSectors":
        """The sectors of some of the bodies (M,)."""
        return ShadowSectors(*(part[bodies] for part in self))


def shadow_sectors(centre: Floats, radius: Floats, antenna: Floats) -> ShadowSectors:
    """The sectors behind spheres about `centre` (N, 3), of `radius` (N,) [m], from the antenna (3,) on the map."""
    east, north = centre[:, 0] - antenna[0], centre[:, 1] - antenna[1]
    distance, radius = np.hypot(east, north), radius * 1.01 + 1.0  # 1 m: the bend and rounding
    sine = np.divide(radius, distance, out=np.ones_like(distance), where=distance > radius)
    half = np.where(distance > radius, np.arcsin(sine), np.pi)
    return ShadowSectors(np.arctan2(east, north), half, np.maximum(0.0, distance - radius))


def on_the_way(plan: Floats, body: int, antenna: Floats, moved: Floats) -> Flags:
    """Which circles (B, 3) in plan, middle and radius [m], touch what lies between an antenna (2,) and one of them.

    moved: how far each may be from there (B,) [m].
    """
    line, toward = plan[body, :2] - antenna, plan[:, :2] - antenna
    along = np.clip(toward @ line / max(float(line @ line), 1e-12), 0.0, 1.0)
    miss = np.hypot(*(toward - along[:, None] * line).T)
    near: Flags = miss <= (plan[:, 2] + plan[body, 2]) * 1.001 + 1.0 + moved
    near[body] = False
    return near


def top_slopes(centre: Floats, radius: Floats, top: Floats, antenna: Floats, earth_radius: float) -> Floats:
    """Slopes (N,) over horizontal that no line of sight from the antenna (3,) exceeds which meets one of N bodies.

    centre, radius: of bounding spheres (N, 3) and (N,) [m]; top: highest points of the bodies (N,), on the map [m]. A line of
    sight keeps its slope z / d, where z = up - d^2 / (2 ae), all the way.
    """
    distance, radius = np.hypot(centre[:, 0] - antenna[0], centre[:, 1] - antenna[1]), radius * 1.01 + 1.0
    near, rise = distance - radius, top + ROUNDING + radius**2 / earth_radius - antenna[2]
    begin = np.where(near > 0.0, near, 1.0)
    slope = rise / np.where(rise > 0.0, begin, distance + radius) - begin / (2.0 * earth_radius)
    return np.where(near > 0.0, slope, np.inf)


def points_behind(
    sectors: ShadowSectors, azimuth: Floats, distance: Floats, slopes: tuple[Floats, Floats] | None = None
) -> Iterator[tuple[Indices, Indices]]:
    """Pairs (P,) of a body and a point of (E,) that it may occlude, some bodies at a time, by rising body.

    azimuth: of the points, -pi to pi [rad]; distance: along the ground [m]; slopes: `top_slopes` of the bodies (N,), and those of
    the lines of sight to the points (E,).
    """
    if not len(azimuth):
        return
    order = np.argsort(azimuth)  # a stable sort takes seven times as long
    rising, farthest = azimuth[order], float(distance.max())
    bodies = _among(sectors, azimuth, farthest)
    first, last = _edges(rising, sectors.middle[bodies], sectors.half[bodies])
    tops, lines = (np.zeros(len(sectors.begin)), np.zeros(len(azimuth))) if slopes is None else slopes
    points = _SightPoints(order, distance[order], lines[order])
    pairs: list[tuple[Indices, Indices]] = []
    for part in batches(np.maximum(last - first, 0).sum(axis=1), PAIRS // 2):
        row = np.repeat(bodies[part], TURNS)
        pairs.append(_in_sectors(row, first[part].ravel(), last[part].ravel(), sectors.begin, tops, points))
        if sum(len(body) for body, _ in pairs) > PAIRS // 2:  # few pairs at a time take as many calls
            yield _joined(pairs)
            pairs = []
    if any(len(body) for body, _ in pairs):
        yield _joined(pairs)


class _SightPoints(NamedTuple):
    """Points (E,) by rising azimuth: their order, ground distances [m] and slopes of the lines of sight."""

    order: Indices
    distance: Floats
    slope: Floats


def _in_sectors(
    body: Indices, first: Indices, last: Indices, begin: Floats, top: Floats, points: _SightPoints
) -> tuple[Indices, Indices]:
    """Pairs (P,) of the bodies of sectors (S,) and those of their points, from `first` to `last`, that lie behind.

    begin, top: of all bodies (B,), distances of their sectors' starts [m] and top slopes.
    """
    room = int(np.maximum(last - first, 0).sum())
    bodies, behind = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
    count = KERNELS.points_behind(len(body), room, body, first, last, begin, top, *points, bodies, behind)
    return bodies[:count], behind[:count]


def _joined(pairs: list[tuple[Indices, Indices]]) -> tuple[Indices, Indices]:
    """Pairs of several arrays in one."""
    bodies, points = (np.concatenate(column) for column in zip(*pairs, strict=True))
    return bodies, points


def _among(sectors: ShadowSectors, azimuth: Floats, farthest: float) -> Indices:
    """The bodies whose sectors have a part among azimuths (E,), begun at the farthest point [m] at the latest."""
    relative = wrap_angle(azimuth - azimuth[0])
    low, high = float(relative.min()), float(relative.max())
    aside = np.abs(wrap_angle(sectors.middle - (azimuth[0] + (low + high) / 2.0)))
    return np.flatnonzero(
        (aside <= sectors.half + (high - low) / 2.0 + 1e-9) & (sectors.begin <= farthest)
    )  # 1e-9: rounding


def _edges(rising: Floats, middle: Floats, half: Floats) -> tuple[Indices, Indices]:
    """First and last (exclusive) of the rising azimuths (E,) [-pi, pi] in each sector (N,), for three turns (N, TURNS) [rad]."""
    turns = 2.0 * np.pi * np.arange(-1, TURNS - 1)
    first = np.searchsorted(rising, (middle - half)[:, None] + turns)
    last = np.searchsorted(rising, (middle + half)[:, None] + turns, side="right")
    round_about = half >= np.pi
    first[round_about], last[round_about] = 0, [len(rising), 0, 0]  # each point once
    return first, last
