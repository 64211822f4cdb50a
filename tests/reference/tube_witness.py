"""Witness of the kernel that follows ray tubes: where they hit a body after reflection, halved and cut, in plain numpy.

`reflect_tubes` and `take_tubes` take what the kernels of these names take. Rays at the centre of a tube and near its corners are
traced; where they hit different planes, the tube is halved, or cut in a straight line along the edge between two planes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.ray_tubes import cross, dot

OFFSET, OFFSET_RELATIVE, STEEP = 1e-3, 1e-6, 0.1  # of the starts of rays off the surface
INSET, ASIDE, SECTIONS, SAMPLED, CARRIED_HALVINGS = 0.02, 0.05, 4, 4, 1
GRAZING, TINY, ALIKE = 0.01, 1e-30, 1e-6  # the last of lengths and areas: those that differ by less may be equal
_kept: dict[int, "Tubes"] = {}  # tubes that wait for `take_tubes`, by what stands for their address


@dataclass
class Trace:
    """What all steps use: the arguments of `reflect_tubes`, and `hit`: triangles that rays (N, 3, M) in such directions hit."""

    arguments: dict[str, Any]
    hit: Callable[[Floats, Floats], Indices]

    def __getattr__(self, name: str) -> Any:
        return self.arguments[name]


@dataclass
class Tubes:
    """Tubes (M,), columns as of the kernel; parent: (M,) of the tubes given."""

    parent: Indices
    triangle: Indices
    corners: Floats
    centre: Floats
    normal: Floats
    direction: Floats
    begin: Floats
    length: Floats

    def __len__(self) -> int:
        return len(self.parent)

    def chosen(self, which: Indices) -> "Tubes":
        return Tubes(*(column[..., which] for column in vars(self).values()))


def reflect_tubes(
    count: int, triangles: int, starts: int, last: int, most: int, halvings: int, cut_level: int, corners: Floats, centre: Floats,
    normal: Floats, direction: Floats, field: Floats, begin: Floats, length: Floats, launched: Indices, triangle: Indices,
    bounces: Indices, out: Floats, out_field: Floats, least: Indices, longest: Floats, vertices: Floats, faces: Indices,
    rank: Indices, smallest: Floats, plane: Indices, point: Floats, plane_normal: Floats, centre_of_body: Floats, radius: float,
    rotation: Floats, rays: Any, result: Indices,
) -> int:  # fmt: skip
    def hit(start: Floats, along: Floats) -> Indices:
        along = np.broadcast_to(along, start.shape)
        first, ways = (vectors.transpose(0, 2, 1).reshape(-1, 3) @ rotation for vectors in (start, along))
        singles = [np.ascontiguousarray(each, dtype=np.float32) for each in (first - centre_of_body, ways)]
        struck = np.full(len(first), -2, dtype=np.int64)
        if len(first) and rays(len(first), *(each.ctypes.data for each in singles), struck.ctypes.data):
            raise KeyboardInterrupt
        return struck.reshape(len(start), start.shape[2])

    trace = Trace({name: value for name, value in locals().items() if name not in ("hit", "rays")}, hit)
    tubes = Tubes(np.arange(count), triangle, corners, centre, normal, direction, begin, length)
    landed = projected(all_levels(trace, tubes), point, plane_normal)
    result[0] = len(_kept) + 1
    _kept[int(result[0])] = landed
    return len(landed)


def take_tubes(
    count: int, address: int, parent: Indices, triangle: Indices, corners: Floats, centre: Floats, normal: Floats,
    direction: Floats, begin: Floats, length: Floats,
) -> int:  # fmt: skip
    columns = vars(_kept.pop(address)).values()
    for column, value in zip((parent, triangle, corners, centre, normal, direction, begin, length), columns, strict=True):
        column[:] = value
    return count


def all_levels(trace: Trace, tubes: Tubes) -> Tubes:
    """The parts of all tubes that land."""
    rank, hit, done, left = trace.rank, samples(trace, tubes), [tubes.chosen(np.arange(0))], trace.most
    plane = np.append(trace.plane, -1)  # the last one for rays that hit nothing
    for level in range(trace.halvings + 1):
        start = trace.launched[tubes.parent]
        counts = rank[hit] >= trace.least[start]
        lands = counts if trace.last else hit >= 0
        kept, number = lands[0], np.where(lands, plane[hit], -1)
        compared = number if trace.last or level < CARRIED_HALVINGS else np.where(counts, number, -1)
        edges = ((tubes.corners[[1, 2, 0]] - tubes.corners) ** 2).sum(axis=1)
        longest = edges.max(axis=0, initial=0.0)
        mixed = (compared[1:] != compared[0]).any(axis=0) & (longest > trace.smallest[tubes.triangle] ** 2)
        mixed |= counts[0] & (longest > trace.longest[start] ** 2)
        left = 0 if level == trace.halvings else left
        if level >= trace.cut_level:
            cut, parts = cut_at_edges(trace, tubes, hit, number, np.flatnonzero(mixed), left < np.count_nonzero(mixed))
            done.append(parts)
            mixed[cut] = kept[cut] = False
        divided = largest(np.flatnonzero(mixed), areas(tubes.corners.transpose(2, 0, 1)), left)
        left -= len(divided)
        kept[divided] = False
        hitting = np.flatnonzero(kept)
        done.append(replace(tubes.chosen(hitting), triangle=hit[0, hitting]))
        if not len(divided):
            break
        tubes, hit = halved(trace, tubes.chosen(divided), hit[:, divided], first_largest(edges[:, divided]))
    return Tubes(*(np.concatenate([vars(part)[name] for part in done], axis=-1) for name in vars(tubes)))


def largest(which: Indices, size: Floats, count: int) -> Indices:
    """Of tubes `which`, the `count` largest ones by `size` (M,)."""
    rank = np.round(np.log(np.maximum(size[which], TINY)) / ALIKE)
    return np.sort(which[np.argsort(-rank, kind="stable")[: max(count, 0)]])


def lift(trace: Trace, tubes: Tubes) -> Floats:
    """How far along the reflected rays (3, M) they start, off the surface [m]."""
    steep = np.maximum(dot(trace.normal[:, tubes.parent], tubes.direction), STEEP)
    return np.asarray((OFFSET + OFFSET_RELATIVE * trace.radius) / steep * tubes.direction)


def samples(trace: Trace, tubes: Tubes) -> Indices:
    """The triangles (4, M) that rays from the centre and, of the largest tubes, from near the corners hit."""
    large = largest(np.arange(len(tubes)), areas(tubes.corners.transpose(2, 0, 1)), SAMPLED * trace.most)
    off = lift(trace, tubes)
    corners = (tubes.corners + INSET * (tubes.centre - tubes.corners) + off)[..., large]
    hit = np.repeat(trace.hit((tubes.centre + off)[None], tubes.direction), 4, axis=0)
    hit[1:, large] = trace.hit(corners, tubes.direction[:, large])
    return hit


def halved(trace: Trace, tubes: Tubes, hit: Indices, edge: Indices) -> tuple[Tubes, Indices]:
    """Both halves (2 M,) of each tube, and what their rays (4, 2 M) hit."""
    turn, count = (edge + np.arange(3)[:, None]) % 3, len(tubes)
    a, b, c = np.take_along_axis(tubes.corners, turn[:, None, :], axis=0)
    middle = (a + b) / 2.0
    corners = np.concatenate([np.stack([a, middle, c]), np.stack([middle, b, c])], axis=2)
    twice, off = moved(trace, tubes.chosen(np.tile(np.arange(count), 2)), corners), lift(trace, tubes)
    (at_middle,) = trace.hit((middle + INSET * (tubes.centre - middle) + off)[None], tubes.direction)
    (centres,) = trace.hit((twice.centre + np.tile(off, 2))[None], twice.direction)
    a, b, c = np.take_along_axis(hit[1:], turn, axis=0)
    halves = [np.stack([centres[:count], a, at_middle, c]), np.stack([centres[count:], at_middle, b, c])]
    return twice, np.concatenate(halves, axis=1)


def moved(trace: Trace, tubes: Tubes, corners: Floats) -> Tubes:
    """Parts (M,) of tubes with these corners (3, 3, M) [m], and the wave at their own centres."""
    centre = (corners[0] + corners[1] + corners[2]) / 3.0
    offset = centre - tubes.centre
    along = dot(offset, tubes.direction)
    across = offset - along * tubes.direction
    direction = tubes.direction + across / tubes.length
    direction /= np.sqrt(dot(direction, direction))
    length = tubes.length + along + dot(across, across) / (2.0 * tubes.length)
    start, field = trace.launched[tubes.parent], trace.field[:, tubes.parent]
    out, out_field = trace.out[:, start], trace.out_field[:, start]
    sign = np.where(trace.bounces[tubes.parent] % 2, -1.0, 1.0)  # each reflection mirrors the direction, and turns the field
    before = dot(across, field) * sign * out_field + dot(across, cross(tubes.direction, field)) * cross(out, out_field)
    return replace(tubes, corners=corners, centre=centre, direction=direction, length=length, begin=tubes.begin + before)


def counting(trace: Trace, hit: Indices, tubes: Tubes) -> Indices:
    """Planes (..., M) that rays of tubes hit, -1 where these do not count."""
    lands = trace.rank[hit] >= trace.least[trace.launched[tubes.parent]] if trace.last else hit >= 0
    return np.where(lands & (hit >= 0), trace.plane[hit], -1)


def cut_at_edges(
    trace: Trace, tubes: Tubes, hit: Indices, number: Indices, mixed: Indices, final: bool
) -> tuple[Indices, Tubes]:
    """Those of the tubes `mixed` that one straight line divides between two planes, and their parts that count."""
    corner, centre = number[1:, mixed], number[0, mixed]
    alone = np.where(corner[1] == corner[2], 0, np.where(corner[0] == corner[2], 1, 2))
    turn = (alone + np.arange(3)[:, None]) % 3
    tip, beyond, third = np.take_along_axis(corner, turn, axis=0)
    odd = np.flatnonzero((beyond == third) & (tip != beyond) & ((centre == tip) | (centre == beyond)))
    which, turn, tip, beyond = mixed[odd], turn[:, odd], tip[odd], beyond[odd]
    some = tubes.chosen(which)
    a, b, c = corners = np.take_along_axis(some.corners, turn[:, None, :], axis=0)
    at = np.take_along_axis(hit[1:, which], turn, axis=0)
    first, second = crossings(trace, some, corners, at, tip)
    ab, ac = a + first * (b - a), a + second * (c - a)
    line = ab + np.array([0.25, 0.75])[:, None, None] * (ac - ab)
    sides = np.concatenate([line + ASIDE * (a - line), line + ASIDE * ((b + c) / 2.0 - line)]) + lift(trace, some)
    explained = np.arange(len(which))
    if not final:
        beside = counting(trace, trace.hit(sides, some.direction), some)
        explained = np.flatnonzero((beside == np.stack([tip, tip, beyond, beyond])).all(axis=0))
    parts = []
    for shape, triangle, lands in ([[a, ab, ac], at[0], tip], [[ab, b, c], at[1], beyond], [[ab, c, ac], at[1], beyond]):
        kept = explained[lands[explained] >= 0]
        parts.append(moved(trace, replace(some.chosen(kept), triangle=triangle[kept]), np.stack(shape)[:, :, kept]))
    joined = Tubes(*(np.concatenate([vars(part)[name] for part in parts], axis=-1) for name in vars(some)))
    return which[explained], joined


def crossings(trace: Trace, tubes: Tubes, corners: Floats, hit: Indices, tip: Indices) -> Floats:
    """Where the edge between planes crosses the first corner's two edges (2, M), in shares of their length: rays bracket it, and
    where an edge of the triangles at both ends of the bracket crosses it, the place is exact."""
    inset = corners + INSET * (tubes.centre - corners)
    way, share = inset[1:] - inset[0], np.arange(1, SECTIONS) / SECTIONS
    points = (inset[0] + share[:, None, None, None] * way).reshape(2 * len(share), 3, len(tubes)) + lift(trace, tubes)
    struck = trace.hit(points, tubes.direction).reshape(len(share), 2, len(tubes))
    passed = np.logical_and.accumulate(counting(trace, struck, tubes) == tip, axis=0).sum(axis=0)
    every = np.concatenate([np.broadcast_to(hit[0], (1, 2, len(tubes))), struck, hit[None, 1:]])
    ends = np.take_along_axis(every, np.stack([passed, passed + 1]), axis=0)
    middle = (passed + 0.5) / SECTIONS
    vertices = trace.vertices[trace.faces[ends]].transpose(4, 0, 3, 1, 2)  # axis, end, corner, edge, tube
    direction, way = tubes.direction[:, None, None, None], way.transpose(1, 0, 2)[:, None, None]
    across = cross(vertices[:, :, [1, 2, 0]] - vertices, direction)
    slope, height = dot(way, across), dot(vertices - inset[0][:, None, None, None], across)
    usable = (np.abs(slope) > 1e-12) & (ends[:, None] >= 0)
    place = np.divide(height, slope, out=np.full(slope.shape, np.inf), where=usable).reshape(6, *middle.shape)
    best = np.take_along_axis(place, np.abs(place - middle).argmin(axis=0)[None], axis=0)[0]
    return line_through(np.where(np.abs(best - middle) < 0.6 / SECTIONS, best, middle), INSET)


def projected(tubes: Tubes, point: Floats, plane_normal: Floats) -> Tubes:
    """Tubes projected along their direction onto the plane of `triangle`, without those that graze it or lie behind it."""
    normal = plane_normal[tubes.triangle].T
    facing = dot(normal, tubes.direction)
    normal, facing = np.where(facing > 0.0, -normal, normal), np.abs(facing)
    height = dot(tubes.corners.transpose(1, 0, 2), normal[:, None]) - dot(point[tubes.triangle].T, normal)
    travel = height / np.maximum(facing, GRAZING)
    corners, middle = tubes.corners + travel[:, None] * tubes.direction, (travel[0] + travel[1] + travel[2]) / 3.0
    centre, length = tubes.centre + middle * tubes.direction, tubes.length + middle
    result = replace(tubes, corners=corners, centre=centre, normal=normal, length=length)
    return result.chosen(np.flatnonzero((middle > 0.0) & (facing > GRAZING)))


def line_through(crossing: Floats, inset: float) -> Floats:
    """Where a straight line meets the two edges of triangles' first corners (2, M), in shares of their length, 0 to 1, by where
    it crosses those of smaller triangles, whose corners lie `inset` of the way to the centroid."""
    third = inset / 3.0
    x, y = third + (1.0 - inset) * crossing  # the line passes through (x, third) and (third, y)
    along = x * y - third * third
    return np.clip(np.stack([along / np.maximum(y - third, 1e-9), along / np.maximum(x - third, 1e-9)]), 1e-9, 1.0)


def first_largest(values: Floats) -> Indices:
    """Of rows (R, M) the first one (M,) whose value is the largest. Values that differ by less than ALIKE of it count as equal,
    so that the rounding of a rotated body decides nothing."""
    return np.asarray((values >= (1.0 - ALIKE) * values.max(axis=0, initial=0.0)).argmax(axis=0))
