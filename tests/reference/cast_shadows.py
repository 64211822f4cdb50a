"""Slow reference: the shadows that convex bodies cast on flat faces, directly and by the sea, sharing no code with the engine.

A picture is drawn on an upright plane before the antenna. A point is (right / ahead, up / ahead), as the ray that reaches it
leaves the antenna. So the rays by the sea have a picture too, in which points lie as their mirror images do. A straight edge
stays straight in both pictures over a flat sea, and over a curved one to millimetres. A convex body covers the convex hull
of its corners. By the sea it covers what it stops on the way to the sea and what it stops behind the reflection.

Positions are east, north and height above the sea about the foot of the antenna [m].
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tests.reference.metal_on_water import Floats, Setting, clipped, dry, reflection_distance

NEAREST = 1.0  # m ahead of the antenna: nearer parts of a body are left out
SMALLEST = 1e-7  # m^2: pieces below it are left out
CUTS = 4  # points of each edge of an occluder, as edges bend over the curved sea


class Piece(NamedTuple):
    """A convex part (V, 3) of a face, and whether the direct way and the way by the sea reach it."""

    corners: Floats
    direct: bool
    sea: bool


def homogeneous(points: Floats, ahead: Floats, setting: Setting, by_sea: bool) -> Floats:
    """Right, up and ahead (M, 3) of points (M, 3) in a picture about the bearing `ahead` (2,), a unit vector."""
    right = points[:, 0] * ahead[1] - points[:, 1] * ahead[0]
    front = points[:, :2] @ ahead
    distance = np.hypot(points[:, 0], points[:, 1])
    if not by_sea:
        return np.stack(
            [right, points[:, 2] - setting.antenna_height - distance**2 / (2 * setting.earth_radius), front], axis=1
        )
    x = reflection_distance(distance, np.maximum(points[:, 2], 1e-9), setting.antenna_height, setting.earth_radius)
    slope = -(setting.antenna_height + x**2 / (2.0 * setting.earth_radius)) / x
    return np.stack([right, slope * distance, front], axis=1)


def picture_of(solid: Sequence[Floats], ahead: Floats, setting: Setting, by_sea: bool) -> Floats | None:
    """The convex hull (W, 2), counterclockwise, of what of a solid is above the sea and before the antenna; None: nothing."""
    corners = []
    for face in solid:
        part = dry(face)
        part = clipped(part, part[:, :2] @ ahead - NEAREST) if len(part) else part
        following = np.roll(part, -1, axis=0)
        corners += [part + share * (following - part) for share in np.arange(CUTS) / CUTS]
    points = np.concatenate(corners)
    if not len(points):
        return None
    flat = homogeneous(points, ahead, setting, by_sea)
    flat = flat[:, :2] / flat[:, 2:]
    try:
        return np.asarray(flat[ConvexHull(flat).vertices])
    except QhullError:  # edge-on
        return None


def in_front(solid: Sequence[Floats], other: Sequence[Floats]) -> bool:
    """Whether a body stands before another one on rays from the antenna: on its side of an upright plane between both."""
    one, two = (np.concatenate(faces)[:, :2] for faces in (solid, other))
    gap, nearer = 0.0, False
    for points in (one, two):
        ring = points[ConvexHull(points).vertices]
        for edge in np.roll(ring, -1, axis=0) - ring:
            normal = np.array([edge[1], -edge[0]]) / np.hypot(*edge)
            a, b = one @ normal, two @ normal
            for sign, (low, high) in ((1.0, (a.max(), b.min())), (-1.0, (b.max(), a.min()))):
                if high - low > gap:
                    gap, nearer = high - low, bool(sign * (low + high) > 0.0)
    if gap <= 0.0:
        raise ValueError("bodies of a draw must not touch")
    return nearer


def lit_pieces(
    face: Floats, occluders: Sequence[Sequence[Floats]], before: Sequence[bool], ahead: Floats, setting: Setting
) -> list[Piece]:
    """The parts of a convex face (V, 3) that a way reaches. before: which occluders stand before the face's body; the others
    cast their shadow on the way from the antenna to the sea alone."""
    pieces = [Piece(face, True, setting.sea)] if len(face) else []
    for solid, nearer in zip(occluders, before, strict=True):
        direct = picture_of(solid, ahead, setting, False)
        if direct is not None and nearer:
            pieces = covered(pieces, direct, ahead, setting, False, False)
        if setting.sea and direct is not None:
            pieces = covered(pieces, direct, ahead, setting, True, True)
        if setting.sea and nearer:
            behind = picture_of(solid, ahead, setting, True)
            pieces = pieces if behind is None else covered(pieces, behind, ahead, setting, True, True)
    return [piece for piece in pieces if piece.direct or piece.sea]


def covered(pieces: list[Piece], hull: Floats, ahead: Floats, setting: Setting, by_sea: bool, of_sea: bool) -> list[Piece]:
    """Pieces cut at a hull (W, 2) of a picture, direct or `by_sea`; within it the way does not arrive, direct or `of_sea`."""
    result = []
    for piece in pieces:
        inside: Floats = piece.corners
        for start, stop in zip(hull, np.roll(hull, -1, axis=0), strict=True):
            along = stop - start
            line = np.array([-along[1], along[0], along[1] * start[0] - along[0] * start[1]]) / np.hypot(*along)
            side = homogeneous(inside, ahead, setting, by_sea) @ line
            outside = clipped(inside, -side)
            if area(outside) > SMALLEST:
                result.append(piece._replace(corners=outside))
            inside = clipped(inside, side)
            if area(inside) <= SMALLEST:
                break
        else:
            result.append(piece._replace(corners=inside, **{"sea" if of_sea else "direct": False}))
    return result


def area(corners: Floats) -> float:
    """Area of a flat convex polygon (V, 3) [m^2]."""
    if len(corners) < 3:
        return 0.0
    edges = corners[1:] - corners[0]
    return float(np.linalg.norm(np.cross(edges[:-1], edges[1:]).sum(axis=0))) / 2.0
