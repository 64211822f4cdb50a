"""Shadows that other bodies cast on one: triangles that hide parts of it from the antenna, exactly, and outlines of many.

Triangles are searched for by their windows in the antenna's picture (`picture`), which miss none. The shadow of a triangle is
what lies behind it within the planes through the antenna and its edges. A ray that the sea reflects is stopped on its way to the
sea by what stands in the direct picture, and behind the reflection by what stands in the one by the sea.
"""

from collections.abc import Sequence
from copy import copy
from itertools import compress
from typing import NamedTuple, Self

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Flags, Floats, Indices
from radar_service.scattering.physical_optics.picture import NEAREST, Picture, Windows
from radar_service.scattering.physical_optics.skylines import Outlook
from radar_service.trace import Boxes, TriangleClusters, box_corners
from radar_service.world import MAP_POSE, BodyPose

MAX_TRIANGLES = 4_000  # that cast shadows exactly on a body: more have outlines
RINGS = 32  # about the antenna, of shores between which the sea may reflect rays to a body
NEAR, NEAR_SHARE = 2e-3, 2e-6  # m and share of its distance behind a triangle in which it casts no shadow: as of `occluder`
FEW_TRIANGLES = 32  # triangles of ground that have no outline
CELL = 4.0  # m: ground is looked for once for all bodies and antennas in a cell
BENT = 0.01  # m by which the planes of a hull may bend in a picture, over a body of 500 m

Posed = Sequence[tuple[TriangleClusters, BodyPose]]
AT_LEVEL = 1e-6  # m: what is nearer to the level lies on it, however a rotated body is rounded


class CastShadows:
    """The shadows of triangles (T,) on a body along one leg.

    corners: (T, 3, 3) at virtual positions [m].
    distance: (T,) of the nearest corner from the antenna [m].
    plane, offset: of the planes that bound them, (T, 4, 3) and (T, 4) [m]: those through the edges, and the triangle's own.
    """

    def __init__(self, picture: Picture, corners: Floats) -> None:
        """picture: in which they stand."""
        self.picture = picture
        count = len(corners)
        results = np.empty((count, 3, 3)), np.empty((count, 4, 3)), np.empty((count, 4)), np.empty(count)
        casting = KERNELS.shadow_planes(count, np.ascontiguousarray(corners), *results)
        self.corners, self.plane, self.offset, self.distance = (result[:casting] for result in results)

    @staticmethod
    def none(picture: Picture) -> "CastShadows":
        """No shadows."""
        result = copy(_NONE)
        result.picture = picture
        return result

    def __len__(self) -> int:
        return len(self.corners)

    def on(self, virtual: Floats, moved: Floats | float = 0.0) -> Flags:
        """Which may lie on the hull of points (P, 3) at virtual positions, as these and the shadows (T,) move by so much [m]."""
        side = np.einsum("tkx,px->tkp", self.plane, virtual).max(axis=2)
        return np.asarray((side.T > self.offset.T - BENT - moved).all(axis=0))

    def chosen(self, which: Flags) -> Self:
        """The shadows of triangles `which` (T,)."""
        if which.all():
            return self
        result = copy(self)
        result.corners, result.plane = self.corners[which], self.plane[which]
        result.offset, result.distance = self.offset[which], self.distance[which]
        return result


_NONE = CastShadows(Picture(np.zeros(3), np.inf, False), np.zeros((0, 3, 3)))


class Onlooker(NamedTuple):
    """A body before which others may stand.

    box: corners (8, 3) of a box around what of it rises above the sea, on the map [m].
    legs: the pictures of its legs.
    """

    box: Floats
    legs: tuple[Picture, ...]

    def shadows(self, others: Posed) -> list[CastShadows]:
        """The shadows of other bodies that may lie on it along each leg: of ground by its outline, and of the others too where
        they have too many triangles."""
        own = self.windows() if others else []
        boxes = [pose.map_from_frame(triangles.box) for triangles, pose in others]
        near = list(compress(others, self.stand_before(np.stack(boxes), MAP_POSE, own))) if others else []
        if not near:
            return [CastShadows.none(leg) for leg in self.legs]
        every = [self.ground(*other, own) if other[0].is_ground else self.before(*other, own) for other in near]
        dry = [above_water(corners, 0.0)[0] for corners in every]
        many = MAX_TRIANGLES if sum(map(len, dry)) <= MAX_TRIANGLES else MAX_TRIANGLES // len(near)
        outlined = [
            len(corners) > (min(FEW_TRIANGLES, many) if triangles.is_ground else many)
            for (triangles, _), corners in zip(near, dry, strict=True)
        ]
        exact = list(compress(dry, np.logical_not(outlined)))
        result = []
        for number, leg in enumerate(self.legs):
            outlines = (self._outlines(number, corners, many) for corners in compress(dry, outlined))
            shadows = self._along(number, np.concatenate([np.zeros((0, 3, 3)), *exact]), *outlines)
            result.append(shadows.chosen(shadows.on(leg.virtual(self.box))))
        return result

    def nearest(self, triangles: TriangleClusters, pose: BodyPose, moved: float, own_moved: float) -> float:
        """Distance in plan [m] of the nearest triangle of another body that may cast a shadow on this one; inf: none may.

        moved, own_moved: how far the other body and this one may be from where they are, against the antenna [m].
        """
        corners = above_water(self.before(triangles, pose, self.windows(own_moved), moved), -moved)[0]
        nearest, middle = np.inf, np.hypot(*(self.box[:, :2].mean(axis=0) - self.legs[0].antenna[:2]))
        for number, leg in enumerate(self.legs):
            shadows = self._along(number, corners)
            away = np.maximum(shadows.distance, moved + NEAREST)
            casting = away[shadows.on(leg.virtual(self.box), own_moved + moved * np.maximum(middle / away, 1.0))]
            nearest = min(nearest, float(casting.min(initial=np.inf)))
        return nearest

    def _along(self, number: int, corners: Floats, *outlines: Floats) -> CastShadows:
        """The shadows of triangles (T, 3, 3) on the map [m] along a leg: by the sea a ray may be stopped in both pictures.

        outlines: triangles (N, 3, 3) at virtual positions beside these.
        """
        virtual = [picture.virtual(corners) for picture in self.legs[: number + 1]]
        return CastShadows(self.legs[number], np.concatenate([*virtual, *outlines]))

    def _outlines(self, number: int, corners: Floats, many: int) -> Floats:
        """Triangles (N, 3, 3) at virtual positions that cast the shadow of many on the map (T, 3, 3) [m] along a leg.

        Those wholly before this body become an outline. The others stay; where they are more than `many`, an outline in the
        body's middle stands for what of them lies before that.
        """
        outlook = Outlook.of(self.box, self.legs[number])
        if outlook is None:
            return np.concatenate([picture.virtual(corners) for picture in self.legs[: number + 1]])
        along = (corners[..., :2] - self.legs[0].antenna[:2]) @ outlook.ahead
        before = along.max(axis=1) <= outlook.nearest
        parts, rest = [(corners[before], outlook.nearest)], corners[~before]
        if len(rest) > many:
            parts.append((cut(rest, outlook.middle - along[~before])[0][0], outlook.middle))
            rest = rest[:0]
        pictures = self.legs[: number + 1]
        result = [picture.virtual(rest) for picture in pictures]
        for part, distance in parts:
            virtual = np.concatenate([picture.virtual(part) for picture in pictures])
            result.append(outlook.outlines(virtual, self._rings(number, part), distance))
        return np.concatenate(result)

    def _rings(self, number: int, corners: Floats) -> Indices:
        """Groups of triangles (T, 3, 3) on the map [m] for their outline: (T,), by the sea (2 T,) in both pictures.

        A ray by the sea may pass over one shore, meet the sea and pass below the image of the next. So each picture has rings
        about the antenna, whose shores are a share 1 / RINGS of the body's height apart; no ray meets the sea in ring 0.
        """
        if number == 0:
            return np.zeros(len(corners), dtype=np.int64)
        window, middle = Windows.of(self.box[None], self.legs[1]), corners[..., :2].mean(axis=1) - self.legs[0].antenna[:2]
        distance = np.maximum(np.hypot(middle[:, 0], middle[:, 1]), NEAREST)
        slope = self.legs[0].height(distance, np.zeros(len(corners))) / distance
        share = (slope - window.low) / np.maximum(window.high - window.low, 1e-12)
        ring = np.clip(np.ceil(share * RINGS), 0, RINGS).astype(np.int64)
        return np.concatenate([2 * ring, 2 * ring + 1])

    def before(self, triangles: TriangleClusters, pose: BodyPose, own: Sequence[Windows], moved: float = 0.0) -> Floats:
        """The triangles (T, 3, 3) on the map [m] of another body that may stand before this one along a leg.

        own: as from `windows`. moved: as of `nearest`.
        """
        chosen = triangles.chosen(lambda points: self.stand_before(points, pose, own, moved))
        return pose.map_from_frame(chosen)

    def ground(self, triangles: TriangleClusters, pose: BodyPose, own: Sequence[Windows]) -> Floats:
        """`before` of ground, among what may stand before any body in the cells of space around this one, for any antenna in
        the cell of this one: neighbouring aspects share that."""
        low, high = np.floor(self.box.min(axis=0) / CELL), np.ceil(self.box.max(axis=0) / CELL)
        antenna, legs = np.floor(self.legs[0].antenna / CELL) + 0.5, len(self.legs)
        cells = np.concatenate([low, high, antenna, pose.position, pose.matrix.ravel(), [legs, self.legs[0].earth_radius]])

        def gathered() -> Floats:
            pictures = tuple(leg._replace(antenna=CELL * antenna) for leg in self.legs)
            box = box_corners(Boxes(CELL * low[:, None], CELL * high[:, None]))[0]
            around = self._replace(box=box, legs=pictures)
            wide = around.windows(CELL)
            return triangles.chosen(lambda points: around.stand_before(points, pose, wide, CELL))

        near = triangles.kept.get(cells.tobytes(), gathered)
        return pose.map_from_frame(near[self.stand_before(near, pose, own)])

    def windows(self, own_moved: float = 0.0) -> list[Windows]:
        """The body's windows in the picture of each leg; own_moved: as of `nearest`."""
        return [Windows.of(self.box[None], leg).widened(own_moved) for leg in self.legs]

    def stand_before(self, points: Floats, pose: BodyPose, own: Sequence[Windows], moved: float = 0.0) -> Flags:
        """Which hulls of points (N, P, 3) in a body's frame [m] may stand before this one along a leg; own, moved: as of
        `before`."""
        stand, leg, windows = np.empty(len(points), dtype=np.bool_), self.legs[0], np.array(own).reshape(len(own), -1)
        taken = map(np.ascontiguousarray, (points, pose.matrix, pose.position, leg.antenna))
        sizes = (len(points), points.shape[1], len(own))
        KERNELS.stand_before(*sizes, *taken, leg.earth_radius, moved, windows, stand)
        return stand


def above_water(corners: Floats, level: float) -> tuple[Floats, Indices]:
    """The parts of triangles (M, 3, 3) that rise above `level` [m], and the triangle that each comes from (N,).

    Triangles that lie above as a whole come first, as they are. Others are cut exactly along the level.
    """
    height = corners[:, :, 2] - level
    height[np.abs(height) < AT_LEVEL] = 0.0
    if not (height < 0.0).any():
        return corners, np.arange(len(corners))
    return cut(corners, height)[0]


def cut(corners: Floats, value: Floats) -> tuple[tuple[Floats, Indices], tuple[Floats, Indices]]:
    """The parts of triangles (M, 3, D) where a value is not negative, and those where it is, each with the triangle that it
    comes from (N,).

    value: (M, 3) at the corners; columns of `corners` are interpolated along the edges. Triangles that lie on one side as a
    whole come first, as they are.
    """
    below = value < 0.0
    count = below.sum(axis=1)
    uncut, stumps, tips, none = (np.flatnonzero(count == number) for number in range(4))
    tip, *rest = _divided(corners[tips], value[tips], ~below[tips])
    fall, *stay = _divided(corners[stumps], value[stumps], below[stumps])
    kept = np.concatenate([corners[uncut], tip, *stay]), np.concatenate([uncut, tips, stumps, stumps])
    lost = np.concatenate([corners[none], fall, *rest]), np.concatenate([none, stumps, tips, tips])
    return kept, lost


def _divided(corners: Floats, value: Floats, single: Flags) -> tuple[Floats, Floats, Floats]:
    """Triangles (K, 3, D) whose corner `single` (K, 3) lies alone on its side: the triangle at that corner, and two that make
    up the rest."""
    turn = (single.argmax(axis=1)[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(corners, turn[:, :, None], axis=1).transpose(1, 0, 2)
    at_a, at_b, at_c = np.take_along_axis(value, turn, axis=1).T
    ab, ac = (a + (at_a / (at_a - end))[:, None] * (to - a) for end, to in ((at_b, b), (at_c, c)))
    return np.stack([a, ab, ac], axis=1), np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)
