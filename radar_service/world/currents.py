"""The water's velocity at any position, and how it changes along a way: a stream everywhere, and areas with streams of their own.

Streams add. Across the border of an area its stream rises over the width `border`, half of it on either side, as u^2 (3 - 2 u):
headings and rates of turn of ships that cross it have no steps, and two areas with a common straight border pass over into each
other without a dip.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from radar_service.numerics.types import Flags, Floats
from radar_service.world.stream import NO_STREAM, Stream


@dataclass(frozen=True)
class CurrentArea:
    """A polygon, or a circle.

    stream: of the water inside, east and north [m/s].
    border: width over which it rises [m], above 0.
    corners: of a polygon whose edges do not cross, east and north [m]; or the centre of a circle alone.
    radius: of the circle [m]; 0 for a polygon.
    """

    stream: Stream
    border: float
    corners: tuple[tuple[float, float], ...]
    radius: float = 0.0

    def share(self, position: Floats) -> tuple[Floats, Floats]:
        """Returns the share of the stream (K,) at positions (K, 2) [m], and its gradient (K, 2) [1/m]."""
        share, gradient = np.zeros(len(position)), np.zeros((len(position), 2))
        low, high = self._box
        near = np.flatnonzero(((position >= low) & (position <= high)).all(axis=1))
        if len(near):
            depth, inward = self._in_circle(position[near]) if self.radius else self._in_polygon(position[near])
            u = np.clip(depth / self.border + 0.5, 0.0, 1.0)
            share[near] = u * u * (3.0 - 2.0 * u)
            gradient[near] = (6.0 * u * (1.0 - u) / self.border)[:, None] * inward
        return share, gradient

    @property
    def deepest(self) -> float:
        """No point lies deeper behind the border [m]: the radius, or twice the area over the perimeter."""
        begin, along, length = self._edges
        return self.radius or (float(abs(_cross(begin, along).sum()) / length.sum()) if len(length) else 0.0)

    def _in_circle(self, position: Floats) -> tuple[Floats, Floats]:
        """Depth (K,) [m] behind the border, negative outside, and its gradient (K, 2)."""
        inward = np.array(self.corners[0]) - position
        distance = np.hypot(*inward.T)
        return self.radius - distance, inward / np.maximum(distance, TINY)[:, None]

    def _in_polygon(self, position: Floats) -> tuple[Floats, Floats]:
        """Depth (K,) [m] behind the nearest edge, negative outside, and its gradient (K, 2)."""
        begin, along, length = self._edges
        offset = position[:, None] - begin
        foot = np.clip((offset * along).sum(axis=2) / length**2, 0.0, 1.0)
        outward = offset - foot[:, :, None] * along  # from the nearest point of each edge
        distance = np.hypot(outward[:, :, 0], outward[:, :, 1])
        row, edge = np.arange(len(position)), distance.argmin(axis=1)
        side = np.where(self._holds(offset, begin, along), 1.0, -1.0)
        inward = side[:, None] * outward[row, edge] / np.maximum(distance[row, edge], TINY)[:, None]
        faces = (foot[row, edge] > 0.0) & (foot[row, edge] < 1.0)  # an edge, not a corner: exact on the border, too
        turned_left = np.stack([-along[edge, 1], along[edge, 0]], axis=1) / length[edge, None]
        counterclockwise = 1.0 if _cross(begin, along).sum() > 0.0 else -1.0
        return side * distance[row, edge], np.where(faces[:, None], counterclockwise * turned_left, inward)

    def _holds(self, offset: Floats, begin: Floats, along: Floats) -> Flags:
        """Which positions (K,) at offsets (K, E, 2) from where edges begin lie inside: an odd number is to the east."""
        south = offset[:, :, 1] < 0.0  # of the edge's beginning
        south_of_end = offset[:, :, 1] < along[:, 1]
        west = _cross(along, offset) * np.sign(along[:, 1]) > 0.0
        return np.asarray(((south != south_of_end) & west).sum(axis=1) % 2 == 1)

    @cached_property
    def _edges(self) -> tuple[Floats, Floats, Floats]:
        """Where edges begin (E, 2), where to from there (E, 2) and their lengths (E,) [m], without those of no length."""
        begin = np.array(self.corners)
        along = np.roll(begin, -1, axis=0) - begin
        length = np.hypot(*along.T)
        return begin[length > 0.0], along[length > 0.0], length[length > 0.0]

    @cached_property
    def _box(self) -> tuple[Floats, Floats]:
        """The corners (2,) [m] of the box beyond which nothing of the stream is left."""
        corners, beyond = np.array(self.corners), self.radius + self.border / 2.0
        return corners.min(axis=0) - beyond, corners.max(axis=0) + beyond


TINY = 1e-300  # m: a distance of 0 has no direction


@dataclass(frozen=True)
class Currents:
    """All streams of a scene. everywhere: east and north [m/s]. areas: whose streams add to it."""

    everywhere: Stream = NO_STREAM
    areas: tuple[CurrentArea, ...] = ()

    def __bool__(self) -> bool:
        """Whether the water moves anywhere."""
        return any(self.everywhere) or bool(self.areas)

    def at(self, position: Floats) -> Floats:
        """Returns the velocity of the water (..., 2) [m/s] at positions (..., 2 or more) [m]."""
        return self._sum(position, None)[0]

    def change(self, position: Floats, velocity: Floats) -> Floats:
        """Returns how fast the velocity of the water (K, 2) [m/s2] changes for who moves (K, 2 or more) [m/s] at positions."""
        return self._sum(position, velocity)[1]

    def _sum(self, position: Floats, velocity: Floats | None) -> tuple[Floats, Floats]:
        flat = position[..., :2].reshape(-1, 2)
        stream, change = np.tile(np.array(self.everywhere), (len(flat), 1)), np.zeros((len(flat), 2))
        for area in self.areas:
            share, gradient = area.share(flat)
            stream += share[:, None] * np.array(area.stream)
            if velocity is not None:
                change += (gradient * velocity[..., :2]).sum(axis=1)[:, None] * np.array(area.stream)
        return stream.reshape(*position.shape[:-1], 2), change


NO_CURRENTS = Currents()


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
