"""Where ray tubes hit a body after reflection: traced by a few rays, halved and cut where these hit different planes.

Rays at the centre of a tube and near its corners are traced. Where they hit different planes, the tube is halved, or cut in a
straight line along the edge between two planes, if a few more rays agree with that. Rays only bracket the edge: where an edge
of a triangle crosses the bracket, it is computed.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import Kernels, kernels
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.facet_integral import specular_reflection
from radar_service.scattering.physical_optics.facets import ALIKE, areas, first_largest, line_through
from radar_service.scattering.physical_optics.lit_facets import Planes
from radar_service.scattering.physical_optics.ray_tubes import EVERY, RayTubes, by_axis, cross, dot, halved, moved
from radar_service.trace.embree import RotatedScene, TriangleScene
from radar_service.world.body import Mesh

# m; a bounce starts this far off its surface (docs/reference-values.md#embree: 0.1 mm still hits itself in 7 % of cases)
OFFSET = 1e-3
OFFSET_RELATIVE = 1e-6  # of the body's radius: ten times float32 rounding of its coordinates
MAX_HALVINGS = 9
CARRIED_HALVINGS = 1  # of tubes that matter only for what they hit next
CUT_LEVEL = 1  # halvings before a tube may be cut: a whole one is sampled too sparsely to know that one line divides it
SECTIONS = 4  # of an edge of a tube, in one of which the crossing is then computed
ASIDE = 0.05  # of the way from the edge to the corners: where rays on both sides of it test that it is straight
MAX_DIVIDED = (2_000, 500)  # tubes at the second surface and at each later one, those of large area first
SAMPLED = 4  # times as many have rays at their corners too: of large tubes, a sixth to a half hit different planes
INSET = 0.02  # of the way from a corner to the centre: rays start off the edges
TINY = 1e-30  # m^2, an area that no tube has
GRAZING = 0.01  # cosine below which a footprint is over a hundred tubes long, and its middle ray no longer represents it
STEEP = 0.1  # cosine below which rays start nearer to the surface than OFFSET


Rays = TriangleScene | RotatedScene


class Ends(NamedTuple):
    """The triangles (F,) of a mesh where tubes end: whether any leg that receives reaches them; their rank; and the length of
    edges below which tubes on them are not divided [m]."""

    mesh: Mesh
    lit: Flags
    rank: Indices
    smallest: Floats


class _Targets(NamedTuple):
    """What rays are traced against: the mesh and its tree; of its triangles, and last of nothing (F + 1,), the number of the
    plane, and the rank by which a tube counts there."""

    scene: Rays
    mesh: Mesh
    plane: Indices
    rank: Indices


def hits(tubes: RayTubes, planes: Planes, scene: Rays, bounces: int, ends: Ends) -> Iterator[RayTubes]:
    """The tubes after each reflection at a surface, up to `bounces` surfaces in all, the first one counted."""
    tubes = replace(tubes, chain=np.pad(tubes.chain, ((0, bounces - 1), (0, 0)), constant_values=-1))
    for bounce in range(2, bounces + 1):
        count = MAX_DIVIDED[min(bounce - 2, 1)]
        tubes = _reflected(tubes.chosen(_may_hit_more(tubes, planes)), planes, scene, ends, bounce == bounces, count)
        if not len(tubes):
            return
        yield tubes


def _reflected(tubes: RayTubes, planes: Planes, scene: Rays, ends: Ends, last: bool, count: int) -> RayTubes:
    """The tubes that hit another surface of the body after reflection at this one, divided where parts of one hit different
    planes; last: without those that do not count there."""
    direction, field = specular_reflection(tubes.direction.T, tubes.field.T, tubes.normal.T)
    tubes = replace(tubes, direction=np.ascontiguousarray(direction.T), field=np.ascontiguousarray(field.T))
    if compiled := kernels():
        return _compiled_reflected(compiled, tubes, planes, scene, ends, last, count)
    plane = np.append(planes.number, -1)  # the last one for rays that hit nothing
    rank = np.append(np.where(ends.lit, ends.rank, EVERY - 1), EVERY - 1)
    landing = rank if last else np.append(np.full(len(ends.lit), np.iinfo(np.int64).max), EVERY - 1)
    targets = _Targets(scene, ends.mesh, plane, landing)
    hit, done, left = _hits_of_samples(tubes, scene, SAMPLED * count), [], count
    for level in range(MAX_HALVINGS + 1):
        counts = rank[hit] >= tubes.launch.least.take(tubes.launched)
        lands = counts if last else hit >= 0
        kept, number = lands[0], np.where(lands, plane[hit], -1)
        compared = number if last or level < CARRIED_HALVINGS else np.where(counts, number, -1)
        edges = _squared_edges(tubes.corners)
        longest = edges.max(axis=0, initial=0.0)
        mixed = (compared[1:] != compared[0]).any(axis=0) & (longest > ends.smallest.take(tubes.triangle) ** 2)
        mixed |= counts[0] & (longest > tubes.launch.longest.take(tubes.launched) ** 2)
        if level == MAX_HALVINGS:
            left = 0
        if level >= CUT_LEVEL:
            final = bool(left < np.count_nonzero(mixed))
            cut, parts = _cut_at_edges(tubes, hit, number, np.flatnonzero(mixed), targets, final)
            done.append(parts)
            mixed[cut] = kept[cut] = False
        divided = largest(np.flatnonzero(mixed), areas(tubes.corners.transpose(2, 0, 1)), left)
        left -= len(divided)
        kept[divided] = False
        hitting = np.flatnonzero(kept)
        done.append(replace(tubes.chosen(hitting), triangle=hit[0, hitting]))
        if not len(divided):
            break
        tubes, hit = _divided(tubes.chosen(divided), hit[:, divided], first_largest(edges[:, divided]), scene)
    return _projected(RayTubes.joined(done), planes)


def _compiled_reflected(
    compiled: Kernels, tubes: RayTubes, planes: Planes, scene: Rays, ends: Ends, last: bool, count: int
) -> RayTubes:
    """Runs the kernel that does what `_reflected` does, for tubes whose directions and fields are reflected already."""
    launch, rank = tubes.launch, np.append(np.where(ends.lit, ends.rank, EVERY - 1), EVERY - 1)
    columns = [
        tubes.corners, tubes.centre, tubes.normal, tubes.direction, tubes.field, tubes.begin, tubes.length, tubes.launched,
        tubes.triangle, tubes.bounces, launch.direction, launch.field, launch.least, launch.longest, ends.mesh.vertices,
        ends.mesh.faces, rank, ends.smallest, planes.number, planes.point, planes.normal, scene.centre,
    ]  # fmt: skip
    sizes = (len(tubes), len(ends.lit), len(launch.least), last, count, MAX_HALVINGS, CUT_LEVEL)
    address = np.zeros(1, dtype=np.int64)
    taken = [np.ascontiguousarray(column) for column in columns]
    rotation = np.ascontiguousarray(scene.rotation)
    number = compiled.run_with_rays("reflect_tubes", scene.first_hit_of, *sizes, *taken, scene.radius, rotation, address)
    parent, triangle = np.empty(number, dtype=np.int64), np.empty(number, dtype=np.int64)
    corners, vectors, length = np.empty((3, 3, number)), np.empty((4, 3, number)), np.empty(number)
    compiled.run("take_tubes", number, int(address[0]), parent, triangle, corners, *vectors, length)
    centre, normal, direction, begin = vectors
    arrived = tubes.chosen(parent)
    arrived.chain[arrived.bounces, np.arange(number)] = triangle
    return replace(
        arrived, corners=corners, centre=centre, normal=normal, triangle=triangle, direction=direction, length=length,
        begin=begin, bounces=arrived.bounces + 1,
    )  # fmt: skip


def largest(which: Indices, size: Floats, count: int) -> Indices:
    """Of tubes `which`, the `count` largest ones by `size` (M,)."""
    if len(which) <= count:
        return which
    rank = np.round(np.log(np.maximum(size[which], TINY)) / ALIKE)
    return np.sort(which[np.argsort(-rank, kind="stable")[:count]])


def _hits_of_samples(tubes: RayTubes, scene: Rays, count: int) -> Indices:
    """The triangles (4, M) that rays from the centre and from near the corners hit, -1 for none. Only the `count` largest tubes
    have rays at their corners; others are taken to hit what their centres hit."""
    large = largest(np.arange(len(tubes)), areas(tubes.corners.transpose(2, 0, 1)), count)
    off = lift(tubes, scene)
    corners = (tubes.corners + INSET * (tubes.centre - tubes.corners) + off).take(large, axis=2)
    directions = np.broadcast_to(tubes.direction.take(large, axis=1), corners.shape)
    hit = np.repeat(_first_hits((tubes.centre + off)[None], tubes.direction[None], scene), 4, axis=0)
    hit[1:, large] = _first_hits(corners, directions, scene)
    return hit


def _first_hits(begin: Floats, direction: Floats, scene: Rays) -> Indices:
    """The triangles (N, M) that rays hit from points (N, 3, M) in directions (N, 3, M)."""
    rays = (vectors.transpose(0, 2, 1).reshape(-1, 3) for vectors in (begin, direction))
    return scene.first_hit(*rays).reshape(len(begin), begin.shape[2])


def lift(tubes: RayTubes, scene: Rays) -> Floats:
    """How far along the reflected rays (3, M) they start, off the surface [m]; so they stay on their lines."""
    steep = np.maximum(dot(tubes.normal, tubes.direction), STEEP)
    return np.asarray((OFFSET + OFFSET_RELATIVE * scene.radius) / steep * tubes.direction)


def _squared_edges(corners: Floats) -> Floats:
    """Squared lengths (3, M) of the edges of triangles (3, 3, M), edge i from corner i to i + 1 [m^2]."""
    x, y, z = (corners[[1, 2, 0]] - corners).transpose(1, 0, 2)
    return np.asarray(x * x + y * y + z * z)


def _divided(tubes: RayTubes, hit: Indices, edge: Indices, scene: Rays) -> tuple[RayTubes, Indices]:
    """Both halves (2 M,) of each tube, and what their rays (4, 2 M) hit. Corners that they have from the whole tube are not
    traced again."""
    turn = (edge + np.arange(3)[:, None]) % 3
    twice, middle = halved(tubes, turn)
    count, aside = len(tubes), middle + INSET * (tubes.centre - middle)
    centre, onward = (column.reshape(3, 2, count).transpose(1, 0, 2) for column in (twice.centre, twice.direction))
    begin = np.concatenate([aside[None], centre]) + lift(tubes, scene)
    at_middle, first, second = _first_hits(begin, np.concatenate([tubes.direction[None], onward]), scene)
    a, b, c = np.take_along_axis(hit[1:], turn, axis=0)
    halves = [np.stack([first, a, at_middle, c]), np.stack([second, at_middle, b, c])]
    return twice, np.concatenate(halves, axis=1)


def _cut_at_edges(
    tubes: RayTubes, hit: Indices, number: Indices, mixed: Indices, targets: _Targets, final: bool
) -> tuple[Indices, RayTubes]:
    """The tubes of `mixed` that one straight line divides between two planes, and their parts that count.

    hit, number: (4, M) triangles that the samples hit, and their planes; final: whether a tube that is not cut now is not
    divided either. The line is found along the two edges of the corner that differs.
    """
    corner = number[1:, mixed]
    alone = np.where(corner[1] == corner[2], 0, np.where(corner[0] == corner[2], 1, 2))
    turn = (alone + np.arange(3)[:, None]) % 3
    tip, plane_beyond, third_plane = np.take_along_axis(corner, turn, axis=0)
    centre = number[0, mixed]
    odd = np.flatnonzero(
        (plane_beyond == third_plane) & (tip != plane_beyond) & ((centre == tip) | (centre == plane_beyond))
    )
    which, turn, tip, plane_beyond, centre = mixed[odd], turn[:, odd], tip[odd], plane_beyond[odd], centre[odd]
    some = tubes.chosen(which)
    a, b, c = corners = np.take_along_axis(some.corners, turn[:, None, :], axis=0)
    first, second = _crossings(some, corners, np.take_along_axis(hit[1:, which], turn, axis=0), tip, targets)
    ab, ac = a + first * (b - a), a + second * (c - a)
    line = ab + np.array([0.25, 0.75])[:, None, None] * (ac - ab)
    sides = np.concatenate([line + ASIDE * (a - line), line + ASIDE * ((b + c) / 2.0 - line)]) + lift(some, targets.scene)
    beside = _counting(_first_hits(sides, np.broadcast_to(some.direction, sides.shape), targets.scene), some, targets)
    explained = (
        np.arange(len(which))
        if final
        else np.flatnonzero((beside == np.stack([tip, tip, plane_beyond, plane_beyond])).all(axis=0))
    )
    own, rest = np.take_along_axis(hit[1:, which], turn[:2], axis=0)
    parts = [
        (np.stack([a, ab, ac]), own, tip),
        (np.stack([ab, b, c]), rest, plane_beyond),
        (np.stack([ab, c, ac]), rest, plane_beyond),
    ]
    kept = [explained[lands[explained] >= 0] for _, _, lands in parts]
    triangle = np.concatenate([hits[some_kept] for (_, hits, _), some_kept in zip(parts, kept, strict=True)])
    cut = np.concatenate([corners[:, :, some_kept] for (corners, _, _), some_kept in zip(parts, kept, strict=True)], axis=2)
    return which[explained], moved(replace(some.chosen(np.concatenate(kept)), triangle=triangle), cut)


def _counting(hit: Indices, tubes: RayTubes, targets: _Targets) -> Indices:
    """Planes (..., M) that rays of tubes hit, -1 where these do not count."""
    return np.where(targets.rank[hit] >= tubes.launch.least.take(tubes.launched), targets.plane[hit], -1)


def _crossings(tubes: RayTubes, corners: Floats, hit: Indices, tip: Indices, targets: _Targets) -> Floats:
    """Where the edge between planes crosses the first corner's two edges (2, M), in shares of their length.

    corners: (3, 3, M), ordered; hit: (3, M) triangles that the samples near them hit; tip: (M,) plane of the first one. Rays
    bracket the edge; where an edge of the triangles at both ends of the bracket crosses it, the place is exact.
    """
    inset = corners + INSET * (tubes.centre - corners)
    way = inset[1:] - inset[0]
    share = np.arange(1, SECTIONS) / SECTIONS
    points = (inset[0] + share[:, None, None, None] * way).reshape(2 * len(share), 3, len(tubes))
    points += lift(tubes, targets.scene)
    struck = _first_hits(points, np.broadcast_to(tubes.direction, points.shape), targets.scene)
    struck = struck.reshape(len(share), 2, len(tubes))
    seen = _counting(struck, tubes, targets) == tip
    passed = np.logical_and.accumulate(seen, axis=0).sum(axis=0)
    every = np.concatenate([np.broadcast_to(hit[0], (1, 2, len(tubes))), struck, hit[None, 1:]])
    ends = np.take_along_axis(every, np.stack([passed, passed + 1]), axis=0)
    middle = (passed + 0.5) / SECTIONS
    vertices = targets.mesh.vertices[targets.mesh.faces[ends]].transpose(4, 0, 3, 1, 2)  # axis, end, corner, edge, tube
    direction, way = tubes.direction[:, None, None, None], way.transpose(1, 0, 2)[:, None, None]
    across = cross(vertices[:, :, [1, 2, 0]] - vertices, direction)
    slope, height = dot(way, across), dot(vertices - inset[0][:, None, None, None], across)
    usable = (np.abs(slope) > 1e-12) & (ends[:, None] >= 0)
    place = np.divide(height, slope, out=np.full(slope.shape, np.inf), where=usable).reshape(6, *middle.shape)
    nearest = np.abs(place - middle).argmin(axis=0)
    best = np.take_along_axis(place, nearest[None], axis=0)[0]
    best = np.where(np.abs(best - middle) < 0.6 / SECTIONS, best, middle)
    return line_through(best, INSET)


def _may_hit_more(tubes: RayTubes, planes: Planes) -> Indices:
    front = dot(tubes.normal, planes.normal.take(tubes.triangle, axis=0).T) > 0.0
    return np.flatnonzero(planes.may_rebounce[tubes.triangle, np.where(front, 0, 1)])


def _projected(tubes: RayTubes, planes: Planes) -> RayTubes:
    """Tubes projected along their direction onto the plane of `triangle`, without those that graze it or lie behind it."""
    point, normal = (by_axis(column.take(tubes.triangle, axis=0)) for column in (planes.point, planes.normal))
    facing = dot(normal, tubes.direction)
    normal = np.where(facing > 0.0, -normal, normal)
    facing = np.abs(facing)
    height = dot(tubes.corners.transpose(1, 0, 2), normal[:, None]) - dot(point, normal)
    travel = height / np.maximum(facing, GRAZING)
    corners = tubes.corners + travel[:, None] * tubes.direction
    middle = (travel[0] + travel[1] + travel[2]) / 3.0
    centre, length = tubes.centre + middle * tubes.direction, tubes.length + middle
    chain = tubes.chain.copy()
    chain[tubes.bounces, np.arange(len(tubes))] = tubes.triangle
    bounces = tubes.bounces + 1
    projected = replace(tubes, corners=corners, centre=centre, normal=normal, length=length, bounces=bounces, chain=chain)
    return projected.chosen(np.flatnonzero((middle > 0.0) & (facing > GRAZING)))
