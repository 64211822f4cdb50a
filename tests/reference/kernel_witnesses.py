"""Witnesses of the compiled kernels: each does in plain numpy what the kernel of its name does, and takes the same arguments.

They share no code with the kernels, and serve nobody but tests (`tests/kernels/both.py`). Shapes are those of the C text.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.sparse import csc_array

from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.facet_integral import CURRENT, specular_reflection
from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.ray_tubes import dot
from tests.reference.facet_integral import corner_phasors, scattering_amplitude
from tests.reference.legs import direct_leg, leg_length, sea_divergence, sea_leg
from tests.reference.shadow_witnesses import (
    cast_cuts,
    cast_dark,
    cast_lit,
    curved,
    own_shadow_hits,
    own_shadow_rays,
    shadow_cuts,
    shadow_edge_step,
    shadow_planes,
    shadow_tips,
    silhouettes,
    skyline,
    stand_before,
)
from tests.reference.tube_witness import GRAZING, reflect_tubes, take_tubes

EDGE_ON = 1e-9  # of the distance: triangles whose plane passes nearer by the antenna cast no shadow
ON_PLANE, BESIDE, ALONG = 1e-6, 1e-9, 1e-5  # m from a plane; rad outside a triangle, and off its side
NORMAL_WEIGHT, FEATURE_STEPS, ALIKE = 1.5, 1e6, 0.8  # of strata
OUTSIDE = 2.1  # radii before a point where its ray begins


def phasors(count: int, phase: Floats, result: Any) -> int:
    result[:] = np.cos(phase) + 1j * np.sin(phase)
    return count


def beam_weights(
    count: int, azimuths: int, entries: int, per_radian: float, boresight: Any, azimuth_change: Any, offset: Any, migration: Any,
    inverse: Any, table: Any, weight: Any,
) -> int:  # fmt: skip
    place = np.abs(boresight - azimuth_change + offset[:, None]) * np.float32(per_radian) + np.float32(0.5)
    weight[:] = table.take(place.astype(np.intp), mode="clip")
    weight /= np.square(migration * inverse[:, None] + np.float32(1.0))
    return count


# ---- grids ----


def spread_points(
    count: int, rows: int, size: int, width_row: int, width_column: int, first_row: Indices, weight_row: Floats,
    first_column: Indices, weight_column: Floats, amplitude: Any, total: Any,
) -> int:  # fmt: skip
    grid = np.zeros((rows, size), dtype=np.complex128)
    r, c = (first_row[:, None] + np.arange(width_row)) % rows, (first_column[:, None] + np.arange(width_column)) % size
    weight = weight_row[:, :, None] * weight_column[:, None, :]
    np.add.at(grid, (r[:, :, None], c[:, None, :]), weight * amplitude[:, None, None])
    total.view(np.complex64)[:] += grid
    return count


def spread_series(
    count: int, all: int, size: int, begin: int, end: int, middle: int, terms: int, width: int, steps: int, column: Floats,
    migration: Any, amplitude: Any, table: Any, rows: Any,
) -> int:  # fmt: skip
    """One product with a sparse matrix, whose columns are the terms of each point."""
    about = np.float32(0.0) if middle < 0 else migration[:, middle : middle + 1]
    shift, fields = migration[:, begin:end] - about, amplitude.view(np.complex64)[:, begin:end]
    position = column if middle < 0 else column + migration[:, middle]
    below = np.floor(position)
    entry, first = ((position - below) * steps + 0.5).astype(np.intp), below.astype(np.int64) - (width // 2 - 1)
    cells = np.repeat(first, terms * width).reshape(count, -1) + np.tile(np.arange(width), terms)
    ends = np.arange(0, cells.size + 1, width)
    weights = csc_array((table[entry].ravel(), (cells % size).ravel(), ends), shape=(size, count * terms))
    series = np.empty((count, terms, end - begin), dtype=np.complex64)
    series[:, 0] = fields
    for power in range(1, terms):
        series[:, power] = series[:, power - 1] * (shift / np.float32(power))
    gridded = weights @ series.reshape(count * terms, end - begin).view(np.float32)
    rows.view(np.complex64)[begin:end] = np.ascontiguousarray(gridded).view(np.complex64).T
    return count


# ---- lines of sight ----


def echo_positions(
    count: int, instants: int, observed: int, bodies: int, matrices: int, which: Indices, place: Floats, own: Floats,
    body: Indices, moves: Flags,
    leans: Indices, pose: Floats, cosine: Floats, sine: Floats, lean: Floats, antenna: Floats, result: Floats,
) -> int:  # fmt: skip
    for n in range(instants):
        for i, (echo, b) in enumerate(zip(which, body[which], strict=True)):
            point = own[echo]
            matrix = lean[n, leans[b]] if leans[b] >= 0 else _turned(cosine[n, b], sine[n, b])
            result[n, :, i] = (matrix @ point + pose[n, b] if moves[b] else place[echo]) - antenna[n]
    return count


def _turned(cosine: float, sine: float) -> Floats:
    """map_from_body of a heading."""
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def lines_of_sight(
    count: int, origins: int, bodies: int, matrices: int, passing: int, earth_radius: float, body: Indices, origin: Floats,
    point: Floats, position: Floats, cosine: Floats, sine: Floats, leans: Indices, lean: Floats, centre: Floats, radius: Floats,
    which: Indices, first: Floats, begin: Floats, line: Floats, skipped: Floats,
) -> int:  # fmt: skip
    kept = 0
    for p, b in enumerate(body):
        matrix = lean[leans[b]] if leans[b] >= 0 else _turned(cosine[b], sine[b])
        start, end = (curved(at - position[b], earth_radius) @ matrix for at in (origin[p if origins > 1 else 0], point[p]))
        way, toward = end - start, centre[b] - start
        squared = max(way @ way, 1e-12)
        progress = way @ toward / squared
        if passing and np.linalg.norm(toward - way * np.clip(progress, 0.0, 1.0)) > radius[b]:
            continue
        share = np.clip(progress - radius[b] / np.sqrt(squared), 0.0, 1.0)
        which[kept], first[kept], begin[kept], line[kept], skipped[kept] = p, start, start + way * share, way, share
        kept += 1
    return kept


def points_behind(
    count: int, room: int, body: Indices, first: Indices, last: Indices, begin: Floats, top: Floats, order: Indices,
    distance: Floats, slope: Floats, bodies: Indices, points: Indices,
) -> int:  # fmt: skip
    pairs = [
        (b, order[i]) for b, low, high in zip(body, first, last, strict=True) for i in range(low, high)
        if distance[i] >= begin[b] and slope[i] <= top[b]
    ]  # fmt: skip
    found = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    bodies[: len(found)], points[: len(found)] = found.T
    return len(found)


# ---- scatterers of surfaces ----


def surface_points(
    count: int, faces: int, points: int, vertices: Floats, corner: Indices, cumulated: Floats, steps: Floats, uv: Floats,
    position: Floats, triangle: Indices,
) -> int:  # fmt: skip
    triangle[:] = np.minimum(np.searchsorted(cumulated, steps, side="right"), faces - 1)
    u, v = np.where(uv.sum(axis=0) > 1.0, 1.0 - uv, uv)
    a, b, c = vertices[corner[triangle]].transpose(1, 0, 2)
    position[:] = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return count


def strata(
    count: int, parts: int, halvings: int, groups: int, position: Floats, direction: Floats, area: Floats, sea: float,
    pick: Indices, chosen: Indices, carried: Floats, middle: Floats, span: Floats,
) -> int:  # fmt: skip
    offset = position - position.mean(axis=0)
    size = np.sqrt(np.average(np.sum(offset**2, axis=1)))
    feature = np.column_stack([offset / max(size, 1e-9), NORMAL_WEIGHT * direction])
    feature = np.rint(feature * FEATURE_STEPS) / FEATURE_STEPS
    group = np.arange(count).reshape(1, -1)
    for pieces in (parts, *[2] * halvings):  # a k-d tree
        values = feature[group]
        axis = np.argmax(values.var(axis=1), axis=1)
        order = np.argsort(np.take_along_axis(values, axis[:, None, None], axis=2)[..., 0], axis=1, kind="stable")
        group = np.take_along_axis(group, order, axis=1).reshape(len(group) * pieces, -1)
    chosen[:] = group[np.arange(groups), pick]
    height = position[group, 2]
    weight = area[group] * (np.einsum("gmi,gi->gm", direction[group], direction[chosen]) > ALIKE)
    above = weight * (height > sea)
    weight = np.where(above.sum(axis=1, keepdims=True) > 0, above, weight)
    weight = weight / weight.sum(axis=1, keepdims=True)
    middle[:] = np.sum(weight * height, axis=1)
    span[:] = np.sqrt(12.0 * np.sum(weight * (height - middle[:, None]) ** 2, axis=1))
    carried[:] = area[group].sum(axis=1)
    return groups


# ---- legs ----


def _at(points: Floats, position: Floats, cosine: float, sine: float) -> Floats:
    return points @ _turned(cosine, sine).T + position


def leg_rays(
    count: int, by_sea: int, points: Floats, position: Floats, cosine: float, sine: float, antenna: Floats, earth_radius: float,
    length: Floats, east: Floats, north: Floats, rise: Floats, flat: Floats, curvature: Floats, tilt: Floats, arrives: Flags,
) -> int:  # fmt: skip
    leg = (sea_leg if by_sea else direct_leg)(_at(points, position, cosine, sine), antenna, earth_radius)
    east[:], north[:] = (leg.level @ _turned(cosine, sine)[:2, :2]).T
    length[:], rise[:], curvature[:], tilt[:], arrives[:] = leg.length, leg.rise, leg.curvature, leg.tilt, leg.arrives
    flat[:] = np.sqrt(np.maximum(1.0 - leg.rise**2, 0.0))
    return count


def leg_weights(
    count: int,
    points: Floats,
    position: Floats,
    cosine: float,
    sine: float,
    antenna: Floats,
    earth_radius: float,
    weight: Floats,
) -> int:
    weight[:] = sea_divergence(_at(points, position, cosine, sine), antenna, earth_radius)
    return count


def leg_lengths(
    count: int, by_sea: int, points: Floats, position: Floats, cosine: float, sine: float, antenna: Floats, earth_radius: float,
    length: Floats,
) -> int:  # fmt: skip
    length[:] = leg_length(_at(points, position, cosine, sine), antenna, earth_radius, bool(by_sea))
    return count


def sags(
    count: int, vectors: int, edge: Floats, east: Floats, north: Floats, rise: Floats, flat: Floats, length: Floats,
    curvature: Floats, result: Floats,
) -> int:  # fmt: skip
    level, upright = edge[0] * north - edge[1] * east, edge[2] * flat - (edge[0] * east + edge[1] * north) * rise
    result[:] = -0.5 * (level**2 / length + upright**2 * curvature)
    return count


# ---- facets ----


def cut_triangles(count: int, room: int, corners: Floats, longest: Floats, parts: Floats, origin: Indices) -> int:
    done = [(part, n) for n in range(count) for part in _halved_to(corners[n], longest[n])]
    for n, (part, of) in enumerate(done[:room]):
        parts[n], origin[n] = part, of
    return len(done)


def _halved_to(triangle: Floats, longest: float) -> list[Floats]:
    edges = np.sqrt(((triangle[[1, 2, 0]] - triangle) ** 2) @ np.ones(3))
    edge = int(edges.argmax())
    if edges[edge] <= longest:
        return [triangle]
    a, b, c = triangle[edge], triangle[(edge + 1) % 3], triangle[(edge + 2) % 3]
    middle = (a + b) / 2.0
    return [*_halved_to(np.stack([a, middle, c]), longest), *_halved_to(np.stack([middle, b, c]), longest)]


def welded(count: int, corners: Floats, number: Indices, points: Floats) -> int:
    known: dict[bytes, int] = {}
    for corner in range(3):
        for i, point in enumerate(corners[:, corner] + 0.0):
            number[corner, i] = known.setdefault(point.tobytes(), len(known))
            points[number[corner, i]] = point
    return len(known)


def dry_facets(
    count: int, points: Floats, corner: Indices, level: float, dry: Indices, crossed: Indices, crossings: Indices
) -> int:
    wet = (points[:, 2] < level)[corner].sum(axis=0)
    of_dry, of_crossed = np.flatnonzero(wet == 0), np.flatnonzero((wet > 0) & (wet < 3))
    dry[: len(of_dry)], crossed[: len(of_crossed)], crossings[0] = of_dry, of_crossed, len(of_crossed)
    return len(of_dry)


def renumbered(count: int, size: int, index: Indices, place: Indices, used: Indices, number: Indices) -> int:
    occurs, number[:] = np.unique(index, return_inverse=True)
    used[: len(occurs)] = occurs
    return len(occurs)


def facet_shapes(count: int, points: Floats, corner: Indices, edges: Floats, centre: Floats, area: Floats) -> int:
    at = points.T[:, corner]
    edges[:], centre[:] = at[:, [1, 2, 0]] - at[:, [2, 0, 1]], at.mean(axis=1).T
    area[:] = np.linalg.norm(np.cross(edges[:, 0].T, edges[:, 1].T), axis=1) / 2.0
    return count


def facet_fields(
    count: int, legs: int, out: int, back: int, level: int, corner: Indices, normal: Floats, area: Floats, side: Any,
    share: Floats, *of_legs: Any,
) -> int:  # fmt: skip
    names = ("east", "north", "rise", "flat", "length", "bend", "phase", "at", "way")
    one, other = (SimpleNamespace(**dict(zip(names, of_legs[first : first + 9], strict=True))) for first in (0, 9))
    visible = share[:, out] * (share[:, back] if back != out else 1.0)
    both = np.flatnonzero((visible > 0.0) & (side[:, out] == side[:, back]))
    current = _current(one, other, normal, level) + (_current(other, one, normal, level) if back != out else 0.0)
    strength = (current * area * visible * side[:, out])[both]
    corner = corner[:, both]
    parts = corner_phasors((one.phase + other.phase)[corner], (one.bend + other.bend)[:, both])
    spreading = one.way[corner] / one.length[both] + other.way[corner] / other.length[both] - 2.0
    np.add.at(of_legs[-1], corner, parts * (1.0 - 0.5 * spreading) * strength)
    return count


def _current(out: Any, back: Any, normal: Floats, level: int) -> Floats:
    """(p . d)(n . E) - (p . E)(n . d) of facets (M,) from a leg into another."""

    def vectors(ray: Any) -> tuple[Floats, Floats]:
        nothing = np.zeros_like(ray.east)
        direction = np.stack([ray.east * ray.flat, ray.north * ray.flat, ray.rise])
        upright = np.stack([-ray.east * ray.rise, -ray.north * ray.rise, ray.flat])
        return direction, np.stack([ray.north, -ray.east, nothing]) if level else upright

    (d, field), (_, received) = vectors(out), vectors(back)
    return np.asarray(dot(received, d) * dot(normal, field) - dot(received, field) * dot(normal, d))


def tube_fields(
    count: int, starts: int, level: int, wavenumber: float, corners: Floats, centre: Floats, direction: Floats, field: Floats,
    normal: Floats, begin: Floats, length: Floats, first_length: Floats, launched: Indices, out: Floats, share: Floats,
    east: Floats, north: Floats, rise: Floats, flat: Floats, back_length: Floats, curvature: Floats, amplitude: Any,
    position: Floats,
) -> int:  # fmt: skip
    back = np.stack([east * flat, north * flat, rise])
    levels, uprights = np.stack([north, -east, 0.0 * east]), np.stack([-east * rise, -north * rise, flat])
    offset = (corners - centre).transpose(1, 0, 2)
    vectors = np.concatenate([offset, offset[:, [1, 2, 0]] - offset[:, [2, 0, 1]]], axis=1)
    along, back_along, aside, up = (dot(vectors, axis[:, None]) for axis in (direction, back, levels, uprights))
    bent = (dot(vectors, vectors) - along**2) / length + aside**2 / back_length + up**2 * curvature
    phases = -wavenumber * (along[:3] + back_along[:3] + bent[:3] / 2.0)
    mean = corner_phasors(phases, wavenumber / 8.0 * bent[3:]).sum(axis=0)
    surface = areas(corners.transpose(2, 0, 1)) * share[launched] * mean
    received = levels if level else uprights
    amplitude[:] = scattering_amplitude(direction.T, field.T, received.T, normal.T, surface, 1.0) / CURRENT
    amplitude *= np.exp(-1j * wavenumber * (length + back_length))
    half, first = (centre - begin) / 2.0, out[:, launched]
    missing = (length - first_length - _spherical(half, first, first_length) - _spherical(-half, back, back_length)) / 2.0
    gradient = (first + back) / 2.0
    position[:] = (begin + half + gradient * (missing / np.maximum(dot(gradient, gradient), 1e-3))).T
    return count


def _spherical(offset: Floats, direction: Floats, length: Floats) -> Floats:
    """How much longer a way (M,) is to points at offsets (3, M) [m]."""
    along = dot(offset, direction)
    return np.asarray(along + (dot(offset, offset) - along * along) / (2.0 * length))


def turned_corners(count: int, corners: Floats, matrix: Floats, turned: Floats, centre: Floats) -> int:
    turned[:] = np.einsum("ik,ckm->cim", matrix, corners)
    centre[:] = turned.mean(axis=0).T
    return count


def kept_tubes(
    count: int, surfaces: int, level: int, water: float, chain: Indices, point: Floats, plane_normal: Floats, east: Floats,
    north: Floats, rise: Floats, flat: Floats, first_length: Floats, begin: Floats, corners: Floats, share: Floats,
    outward: Floats, polarized: Floats,
    centre: Floats, normal: Floats, direction: Floats, field: Floats, length: Floats, bounces: Indices,
    last: Indices,
) -> int:  # fmt: skip
    outward[:] = east * flat, north * flat, rise
    polarized[:] = (north, -east, 0.0 * east) if level else (-east * rise, -north * rise, flat)
    centre[:], direction[:], field[:], length[:] = begin.T, outward, polarized, first_length
    for i in range(count):
        way, electric, at = direction[:, i], field[:, i], corners[:, :, i]
        for number, triangle in enumerate(chain[chain[:, i] >= 0, i]):
            if number:
                turned, electrics = specular_reflection(way[None], electric[None], normal[None, :, i])
                way[:], electric[:] = turned[0], electrics[0]
            facing = plane_normal[triangle]
            normal[:, i] = -facing if facing @ way > 0.0 else facing
            if number:
                along = normal[:, i] @ way
                along = np.copysign(GRAZING, along) if abs(along) < GRAZING else along
                travel = (point[triangle] - at) @ normal[:, i] / along
                at += travel[:, None] * way
                centre[:, i] += travel.mean() * way
                length[i] += travel.mean()
            bounces[i], last[i] = number + 1, triangle
    share *= (begin[:, 2] > water) & (centre[2] > water)
    return count


# ---- the lattice of centres ----


def lattice_nodes(
    count: int, from_zero: int, room: int, points: Floats, steps: Floats, base: Floats, nodes: Floats, corner: Indices,
    share: Floats,
) -> int:  # fmt: skip
    place = (points - base) / steps
    cell = np.floor(place)
    cell[:, 2] = np.maximum(cell[:, 2], 0.0) if from_zero else cell[:, 2]
    aside = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(8, 1, 3)
    share[:] = np.where(aside == 1, place - cell, 1.0 - (place - cell)).prod(axis=2)
    used, number = np.unique((cell + aside).reshape(-1, 3), axis=0, return_inverse=True)
    corner[:] = number.reshape(8, count)
    nodes[: len(used)] = used * steps + base
    return len(used)


def lattice_between(count: int, corner: Indices, share: Floats, values: Floats, result: Floats) -> int:
    result[:] = (share * values[corner]).sum(axis=0)
    return count


def lattice_sums(count: int, begin: int, points: int, corner: Indices, share: Floats, amplitude: Any, total: Any) -> int:
    some = slice(begin, begin + count)
    np.add.at(total, corner[:, some], share[:, some] * amplitude)
    return count


WITNESSES: dict[str, Any] = {
    function.__name__: function
    for function in (
        phasors, beam_weights, spread_points, spread_series, echo_positions, lines_of_sight, points_behind, surface_points,
        strata, leg_rays, leg_weights, leg_lengths, sags, cut_triangles, welded, dry_facets, renumbered, facet_shapes,
        facet_fields, tube_fields, turned_corners, kept_tubes, lattice_nodes, lattice_between, lattice_sums, own_shadow_rays,
        own_shadow_hits, shadow_edge_step, shadow_tips, shadow_cuts, shadow_planes, silhouettes, stand_before, cast_lit,
        cast_dark, cast_cuts, skyline, reflect_tubes, take_tubes,
    )
}  # fmt: skip
