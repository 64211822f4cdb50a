"""Witnesses of the compiled kernels: each does in plain numpy what the kernel of its name does, and takes the same arguments.

They share no code with the kernels, and serve nobody but tests (`tests/kernels/both.py`). Shapes are those of the C text.
"""

from typing import Any

import numpy as np
from scipy.sparse import csc_array

from radar_service.numerics.types import Flags, Floats, Indices
from tests.reference.legs import direct_leg, leg_length, sea_divergence, sea_leg
from tests.reference.shadow_witnesses import curved, shadow_planes, skyline, stand_before

NORMAL_WEIGHT, FEATURE_STEPS, ALIKE = 1.5, 1e6, 0.8  # of strata


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


def weighted_normals(
    rows: int,
    above: int,
    gap: int,
    below: int,
    adds: int,
    state: Indices,
    quantile: Any,
    weight: Any,
    spectrum: Any,
) -> int:
    stream = np.random.SFC64()
    stream.state = {**stream.state, "state": {"state": state.view(np.uint64)}}
    words = np.asarray(stream.random_raw(-(-rows * len(weight) // 4)), dtype=np.uint64).view(np.uint16)
    drawn = quantile[words[: rows * len(weight)]].reshape(rows, -1) * weight
    parts = [drawn[:, :above], np.zeros((rows, gap), dtype=np.float32), drawn[:, above:]]
    spectrum[:] = np.concatenate(parts, axis=1) + (spectrum if adds else np.float32(-0.0))
    return rows


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


def passed_points(
    runs: int, points: int, room: int, columns: int, steps: int, middle: float, half: float, begin: float, end: float,
    step: float, width_cosine: float, near: float, beside: float, earth_radius: float, first: Indices, last: Indices,
    position: Floats, normal: Any, one_sided: Flags, lift: Any, polynomial: Floats, which: Indices, crossing: Floats,
    cosine: Floats,
) -> int:  # fmt: skip
    chosen = np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)] or [first])
    line = polynomial[0, :3] - position[chosen]
    distance = np.hypot(line[:, 0], line[:, 1])
    ahead = np.cos(np.arctan2(-line[:, 0], -line[:, 1]) - middle * step)
    line = curved(line, earth_radius)
    facing = np.sum(line * normal[chosen], axis=1) / np.linalg.norm(line, axis=1)
    facing = np.where(one_sided[chosen], facing, np.abs(facing))
    number = np.full(len(chosen), middle)
    for _ in range(steps):
        u = (number - middle) / half
        at = np.polynomial.polynomial.polyval(u, polynomial)
        velocity = np.polynomial.polynomial.polyval(u, np.polynomial.polynomial.polyder(polynomial)[:, :2]) / half
        offset = np.column_stack([position[chosen, :2], position[chosen, 2] + lift[chosen]]) - at[:3].T
        change = (velocity[1] * offset[:, 0] - velocity[0] * offset[:, 1]) / np.hypot(offset[:, 0], offset[:, 1]) ** 2
        if columns > 4:
            offset = np.einsum("ijn,nj->ni", at[4:].reshape(3, 3, -1), curved(offset, earth_radius))
        left = np.angle(np.exp(1j * (np.arctan2(offset[:, 0], offset[:, 1]) - number * step)))
        number = np.clip(number + left / (step - np.clip(change, -step / 2, step / 2)), middle - 2 * half, middle + 2 * half)
    number[distance <= beside] = middle
    passed = ((distance <= near) | (ahead >= width_cosine)) & (facing > 0.0) & (number >= begin) & (number < end)
    count = int(passed.sum())
    which[:count], crossing[:count], cosine[:count] = chosen[passed], number[passed], facing[passed]
    return count


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
    length: Floats, direction: Floats,
) -> int:  # fmt: skip
    leg = (sea_leg if by_sea else direct_leg)(_at(points, position, cosine, sine), antenna, earth_radius)
    flat = np.sqrt(np.maximum(1.0 - leg.rise**2, 0.0))
    length[:] = leg.length
    direction[:] = np.column_stack([flat[:, None] * (leg.level @ _turned(cosine, sine)[:2, :2]), leg.rise])
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


def lattice_sums(
    count: int, rows: int, row: Indices, corner: Indices, share: Floats, amplitude: Any, nodes: int, total: Any
) -> int:
    np.add.at(total, (row, corner), share * amplitude)
    return rows


WITNESSES: dict[str, Any] = {
    function.__name__: function
    for function in (
        phasors, beam_weights, spread_points, spread_series, echo_positions, lines_of_sight, passed_points, points_behind,
        surface_points,
        strata, leg_rays, leg_weights, leg_lengths, lattice_nodes, lattice_between, lattice_sums, shadow_planes, stand_before,
        skyline, weighted_normals,
    )
}  # fmt: skip
