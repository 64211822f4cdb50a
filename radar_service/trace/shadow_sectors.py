"""Which of many bodies may occlude which points: a quick test in plan, by the sector behind each body's bounding sphere."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Flags, Floats, Indices


class ShadowSectors(NamedTuple):
    """Sectors (N,) that bodies may occlude from the antenna.

    middle, half: azimuth of the middle, and half the width [rad].
    begin: ground distance of the start [m].
    """

    middle: Floats
    half: Floats
    begin: Floats


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


def points_behind(sectors: ShadowSectors, azimuth: Floats, distance: Floats) -> Iterator[tuple[int, Indices]]:
    """The bodies that may occlude any of the points (E,), each with the indices of these points, rising.

    azimuth: of the points, -pi to pi [rad]; distance: along the ground [m].
    """
    if not len(azimuth):
        return
    order = np.argsort(azimuth, kind="stable")
    rising, distance = azimuth[order], distance[order]
    bodies = _among(sectors, azimuth, float(distance.max()))
    first, last = _edges(rising, sectors.middle[bodies], sectors.half[bodies])
    for row in np.flatnonzero((last > first).any(axis=1)):
        body = bodies[row]
        turns = [np.arange(a, b) for a, b in zip(first[row], last[row], strict=True) if a < b]
        inside = np.arange(len(order)) if sectors.half[body] >= np.pi else np.concatenate(turns)
        inside = inside[distance[inside] >= sectors.begin[body]]
        if len(inside):
            yield int(body), np.sort(order[inside])


def _among(sectors: ShadowSectors, azimuth: Floats, farthest: float) -> Indices:
    """The bodies whose sectors have a part among azimuths (E,), begun at the farthest point [m] at the latest."""
    relative = wrap_angle(azimuth - azimuth[0])
    low, high = float(relative.min()), float(relative.max())
    aside = np.abs(wrap_angle(sectors.middle - (azimuth[0] + (low + high) / 2.0)))
    return np.flatnonzero(
        (aside <= sectors.half + (high - low) / 2.0 + 1e-9) & (sectors.begin <= farthest)
    )  # 1e-9: rounding


def _edges(rising: Floats, middle: Floats, half: Floats) -> tuple[Indices, Indices]:
    """First and last (exclusive) of the rising azimuths (E,) [-pi, pi] in each sector (N,), for three turns (N, 3) [rad]."""
    turns = 2.0 * np.pi * np.arange(-1, 2)
    first = np.searchsorted(rising, (middle - half)[:, None] + turns)
    return first, np.searchsorted(rising, (middle + half)[:, None] + turns, side="right")
