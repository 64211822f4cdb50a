"""Slow reference: metal meshes of any shape by physical optics, by brute force, sharing no code with the engine.

Rays leave the antenna, and over the sea also its image, at the corners of square cells. By first hits each has a mark: the planes
that it meets in a row, and by which ways each of these returns. A cell whose corners have one mark is lit as a whole. One whose
corners differ is quartered, as is each neighbour on whose side a new corner differs. From COARSE / FINEST of the first cells on,
one in which two marks meet is parted where its sides go over from one to the other, found by halving: rims of planes are straight
in pictures. Where more meet, quarters go on to 1 / COARSE. All that has one mark is unfolded at its planes: triangles
on the last one, each with the phases of its corners, integrated in closed form. So everything is exact but the rims at corners,
and what is too small for the first cells, whose lattice is turned and placed at random. Convergence is shown by two widths.

Author: this project, from J = 2 n x H (Knott, Shaeffer, Tuley 1985) and geometrical optics at all but the last surface. The earth
is flat. Phases follow exp(+j w t); positions are in a frame with z up [m].
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Integers = NDArray[np.int64]

LIGHT = 299_792_458.0
AT_ONCE = 200_000  # rays or triangles of a pass: some 300 MB
RISE = 1e-6  # of the mesh's extent, by which a ray starts off a surface, for Embree's numbers of 24 bits
COARSE, FINEST = 32, 8  # steps of the lattice of a first cell, and of one that is parted
HALVINGS = 6  # of sides of cells that are parted
FINE = 0.02  # m of the bins of half paths, shared linearly: rounded to bins near half a wave, fields would err in step with them
RANGE, SAG = 0.3, 0.03  # m and rad: triangles that reach farther along the half path, or whose phase bends more, are halved
PLANE_BITS = 18
MASK = 2**PLANE_BITS - 1
SIZES = [32, 16, 8, 4, 2, 1]
SIDES = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])  # corners of a cell, counterclockwise


@dataclass(frozen=True)
class Profile:
    """Fields (3, N) [m], the root of the cross-section, by ways over the sea and by half the path, `first` + FINE n [m].

    Those by the sea lack its coefficient of reflection."""

    first: float
    field: Complexes

    def cells(self, length: float, step: float, low: float, count: int, coefficient: complex = 0.0) -> Complexes:
        """What cells (count,) of a length [m], -3 dB of a Gaussian, see at half paths from `low` on by a step [m]."""
        total = self.field[0] + coefficient * self.field[1] + coefficient**2 * self.field[2]
        filled = np.flatnonzero(total)
        at = low + step * np.arange(count)
        away = (at[:, None] - (self.first + FINE * filled)) / length
        return np.asarray(np.exp(-2.0 * np.log(2.0) * away**2) @ total[filled])


class Mesh:
    """Triangles (F, 3, 3) [m] above the water, for rays."""

    def __init__(self, triangles: Floats, water: float | None) -> None:
        corners = triangles if water is None else np.concatenate([np.zeros((0, 3, 3)), *(dry(t, water) for t in triangles)])
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(across, axis=1)
        self.corners, self.normal = corners[size > 1e-14], across[size > 1e-14] / size[size > 1e-14, None]
        self.offset, self.middle = dots(self.normal, self.corners[:, 0]), corners.reshape(-1, 3).mean(axis=0)
        planes = np.round(np.column_stack([self.normal, self.offset]), 6)
        _, one, plane = np.unique(planes, axis=0, return_index=True, return_inverse=True)
        self.plane, self.plane_normal, self.plane_offset = plane.reshape(-1), self.normal[one], self.offset[one]
        self.rise = RISE * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
        self.radius = float(np.linalg.norm(self.corners - self.middle, axis=2).max())
        assert self.plane.max(initial=0) < MASK
        construction, tracer = (pytest.importorskip(f"embreex.{name}") for name in ("mesh_construction", "rtcore_scene"))
        self._scene = tracer.EmbreeScene(robust=True)
        construction.TriangleMesh(self._scene, (self.corners - self.middle).astype(np.float32))

    def first_hit(self, begin: Floats, direction: Floats) -> NDArray[np.int64]:
        """The triangle (M,) that each ray meets first, -1 where none."""
        rays = (begin - self.middle).astype(np.float32), direction.astype(np.float32)
        return np.asarray(self._scene.run(*rays), dtype=np.int64)

    def clear(self, begin: Floats, end: Floats) -> NDArray[np.bool_]:
        """Whether nothing lies between points (M, 3)."""
        way = end - begin
        rays = (begin - self.middle).astype(np.float32), way.astype(np.float32)
        reach = np.full(len(way), 1.0, dtype=np.float32)
        return np.asarray(self._scene.run(*rays, dists=reach, query="OCCLUDED")) < 0


def dry(triangle: Floats, water: float) -> Floats:
    """What of a triangle (3, 3) lies above the water, as triangles (0 to 2, 3, 3)."""
    height, result = triangle[:, 2] - water, []
    for i in range(3):
        j = (i + 1) % 3
        if height[i] >= 0.0:
            result.append(triangle[i])
        if height[i] * height[j] < 0.0:
            result.append(triangle[i] + (triangle[j] - triangle[i]) * height[i] / (height[i] - height[j]))
    return np.array([[result[0], result[i], result[i + 1]] for i in range(1, len(result) - 1)]).reshape(-1, 3, 3)


def dots(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("...i,...i", a, b))


def unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector, axis=-1, keepdims=True))


def polarized(direction: Floats, name: str) -> Floats:
    """Unit fields (M, 3) of waves that leave the antenna, or its image, along directions (M, 3); "h" is level."""
    level = unit(np.stack([direction[:, 1], -direction[:, 0], np.zeros(len(direction))], axis=1))
    return level if name == "h" else np.cross(level, direction)


class Beams(NamedTuple):
    """Rays (M,) on their way: begin, direction (M, 3), and the number of each (M,)."""

    begin: Floats
    direction: Floats
    number: Integers

    def chosen(self, which: Integers) -> "Beams":
        return Beams(self.begin[which], self.direction[which], self.number[which])


@dataclass(frozen=True)
class Setting:
    """mesh: what is lit; screens: what hides it; receivers: the antenna (3,), over the sea also its image; water: height of the
    sea; bounces: most surfaces in a row; wavelength [m]; polarization: "h" or "v"."""

    mesh: Mesh
    screens: Mesh | None
    receivers: list[Floats]
    water: float | None
    bounces: int
    wavelength: float
    polarization: str


@dataclass(frozen=True)
class Picture:
    """Directions of an eye. frame: eye and axes (4, 3); origin (2,), step: of the lattice of rays [rad]; by_sea: of the image."""

    frame: Floats
    origin: Floats
    step: float
    by_sea: int

    def ways(self, place: Floats) -> Floats:
        """Vectors (..., 3) from the eye toward places (..., 2) of the lattice."""
        u = self.origin + self.step * place
        return np.asarray(self.frame[1] + u[..., :1] * self.frame[2] + u[..., 1:] * self.frame[3])


def profile(
    triangles: Floats, antenna: Floats, width: float, bounces: int = 3, polarization: str = "h",
    water: float | None = None, wavelength: float = LIGHT / 9.41e9, seed: int = 1, screens: Floats | None = None,
) -> Profile:  # fmt: skip
    """What a mesh returns to an antenna (3,). width: of the first cells at the mesh [m]; water: height of the sea; None: there
    is none; screens: triangles of other bodies, which only hide."""
    mesh, rng = Mesh(triangles, water), np.random.default_rng(seed)
    receivers = [antenna] if water is None else [antenna, antenna * (1, 1, -1) + (0, 0, 2.0 * water)]
    hiding = None if screens is None else Mesh(screens, water)
    setting = Setting(mesh, hiding, receivers, water, bounces, wavelength, polarization)
    away = np.linalg.norm(mesh.corners - antenna, axis=2)
    first, span = float(away.min()) - 50.0, 4.0 * float(np.ptp(away)) + 100.0
    total = np.zeros((3, int(span / FINE)), dtype=np.complex128)
    for by_sea, eye in enumerate(receivers):
        ahead, turn = unit(mesh.middle - eye), rng.uniform(0.1, 0.3)
        level = unit(np.cross(ahead, [0.0, 0.0, 1.0]))
        axes = np.array([level, np.cross(level, ahead)])
        seen = (mesh.corners.reshape(-1, 3) - eye) @ np.array([ahead, *axes]).T
        low, high = (s := seen[:, 1:] / seen[:, :1]).min(axis=0), s.max(axis=0)
        turned = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        step = width / COARSE / float(np.linalg.norm(mesh.middle - eye))
        picture = Picture(np.array([eye, ahead, *(turned @ axes)]), turned @ (low + high) / 2.0, step, by_sea)
        half = (high - low) / 2.0 / step
        most = int(np.ceil(np.abs(turned) @ half / COARSE).max()) + 1
        n = COARSE * np.arange(-most, most)
        grid = np.stack(np.meshgrid(n, n), axis=-1).reshape(-1, 2)
        within = np.abs((grid + COARSE / 2 + rng.random(2)) @ turned) < half + COARSE
        part = Partition(picture, setting)
        part.divide(grid[within.all(axis=1)])
        for corners, marks in part.triangles():
            for begin in range(0, len(marks), AT_ONCE):
                some = slice(begin, begin + AT_ONCE)
                add_fields(total, first, corners[some], marks[some], picture, setting)
    return Profile(first, total)


# ------------------------------------------------------------------------------------------------------------------------- rays


def met(place: Floats, picture: Picture, setting: Setting) -> Integers:
    """What rays at places (M, 2) meet: the planes in a row, and which receivers see each, up to the last one that is seen."""
    mesh, marks, rows = setting.mesh, *np.zeros((2, len(place)), dtype=np.int64)
    eye, direction = picture.frame[0], unit(picture.ways(place))
    near = max(float(np.linalg.norm(mesh.middle - eye)) - mesh.radius, 0.0)
    beams = Beams(eye + near * direction, direction, np.arange(len(place)))
    if picture.by_sea and setting.water is not None:
        beams = risen(beams, setting)
    for bounce in range(setting.bounces):
        beams, normal, plane = arrived(beams, mesh)
        if bounce == 0 and setting.screens is not None:
            some = np.flatnonzero(unscreened(beams.begin, picture.by_sea, setting))
            beams, normal, plane = beams.chosen(some), normal[some], plane[some]
        if not len(normal):
            break
        any_back = np.zeros(len(place), dtype=np.bool_)
        rows[beams.number] |= (plane + 1) << (PLANE_BITS * bounce)
        for back, receiver in enumerate(setting.receivers):
            facing = np.flatnonzero(dots(receiver - beams.begin, normal) > 0.0)
            seen = beams.number[facing[reached(beams.begin[facing], back, setting)]]
            rows[seen] |= 1 << (3 * PLANE_BITS + 2 * bounce + back)
            any_back[seen] = True
        marks[any_back] = rows[any_back]
        turned = beams.direction - 2.0 * dots(beams.direction, normal)[:, None] * normal
        beams = Beams(beams.begin + mesh.rise * normal, turned, beams.number)
    return marks


def risen(beams: Beams, setting: Setting) -> Beams:
    """Rays of the image, where they rise from the sea: those that get down to it."""
    mesh, antenna, water = setting.mesh, setting.receivers[0], setting.water
    assert water is not None
    foot = beams.begin + beams.direction * ((water - beams.begin[:, 2]) / beams.direction[:, 2])[:, None] + (0, 0, mesh.rise)
    down = np.flatnonzero(beams.direction[:, 2] > 0.0)
    down = down[mesh.clear(foot[down], np.broadcast_to(antenna, (len(down), 3)))]
    return beams._replace(begin=foot).chosen(down)


def arrived(beams: Beams, mesh: Mesh) -> tuple[Beams, Floats, Integers]:
    """Rays that meet something, with the points where they do as their begins, its normals (M, 3) against them, and planes."""
    hit = mesh.first_hit(beams.begin, beams.direction)
    beams, hit = beams.chosen(np.flatnonzero(hit >= 0)), hit[hit >= 0]
    facing = dots(mesh.normal[hit], beams.direction)
    along = (mesh.offset[hit] - dots(mesh.normal[hit], beams.begin)) / facing
    begin = beams.begin + along[:, None] * beams.direction
    return beams._replace(begin=begin), -np.sign(facing)[:, None] * mesh.normal[hit], mesh.plane[hit]


def reached(point: Floats, back: int, setting: Setting) -> NDArray[np.bool_]:
    """Whether nothing lies between points (M, 3) and a receiver."""
    begin = point + setting.mesh.rise * unit(setting.receivers[back] - point)
    clear = clear_way(setting.mesh, begin, back, setting)
    return clear if setting.screens is None else clear & unscreened(point, back, setting)


def unscreened(point: Floats, back: int, setting: Setting) -> NDArray[np.bool_]:
    """Whether no other body lies between points (M, 3) and a receiver."""
    assert setting.screens is not None
    return clear_way(setting.screens, point, back, setting)


def clear_way(mesh: Mesh, begin: Floats, back: int, setting: Setting) -> NDArray[np.bool_]:
    """Whether nothing of a mesh lies between points (M, 3) and the antenna, by the sea on both parts of the way."""
    antenna, receiver, water = setting.receivers[0], setting.receivers[back], setting.water
    if not back or water is None:
        return mesh.clear(begin, np.broadcast_to(antenna, begin.shape))
    way = receiver - begin
    foot = begin + way * ((water - begin[:, 2]) / way[:, 2])[:, None] + (0, 0, mesh.rise)
    return mesh.clear(begin, foot) & mesh.clear(foot, np.broadcast_to(antenna, foot.shape))


# ------------------------------------------------------------------------------------------------------------------------ cells


class Kept:
    """Marks by places (M, 2) of the lattice."""

    def __init__(self) -> None:
        self._key, self._mark = np.zeros((2, 0), dtype=np.int64)

    def at(self, place: Integers) -> Integers:
        """The marks at places (..., 2), -1 where there is none."""
        if not len(self._key):
            return np.full(place.shape[:-1], -1)
        key = key_of(place)
        index = np.minimum(np.searchsorted(self._key, key), len(self._key) - 1)
        return np.asarray(np.where(self._key[index] == key, self._mark[index], -1))

    def add(self, place: Integers, mark: Integers) -> None:
        """Takes marks at new places, all different."""
        key = key_of(place)
        order = np.argsort(key)
        index = np.searchsorted(self._key, key[order])
        self._key, self._mark = np.insert(self._key, index, key[order]), np.insert(self._mark, index, mark[order])

    def remove(self, place: Integers) -> None:
        kept = ~np.isin(self._key, key_of(place))
        self._key, self._mark = self._key[kept], self._mark[kept]

    @property
    def places(self) -> Integers:
        return np.stack([(self._key >> 32) - 2**30, (self._key & 0xFFFFFFFF) - 2**30], axis=-1)

    @property
    def marks(self) -> Integers:
        return self._mark


def key_of(place: Integers) -> Integers:
    shifted = place + 2**30
    return np.asarray(shifted[..., 0] << 32 | shifted[..., 1])


class Partition:
    """A picture by cells of one mark, and parts of cells."""

    def __init__(self, picture: Picture, setting: Setting) -> None:
        self.picture, self.setting = picture, setting
        self.rays, self.wholes = Kept(), {size: Kept() for size in SIZES}
        self.parts: list[tuple[Floats, Integers]] = []  # polygons (M, 8, 2), of places that may repeat, and their marks
        self.todo: dict[int, list[Integers]] = {size: [] for size in SIZES}

    def divide(self, cells: Integers) -> None:
        """Divides cells (M, 2), given by their least corners."""
        self.todo[COARSE].append(cells)
        while any(self.todo.values()):
            size = next(size for size in SIZES if self.todo[size])
            cells, self.todo[size] = np.concatenate(self.todo[size]), []
            self.divide_alike(cells, size)

    def divide_alike(self, cells: Integers, size: int) -> None:
        """Divides cells of one size."""
        marks = self.marks(cells[:, None] + size * SIDES)
        alike = (marks == marks[:, :1]).all(axis=1)
        self.wholes[size].add(cells[alike], marks[alike, 0])
        if size > 1:
            self.look_about(cells[alike], marks[alike, 0], size)
        rest, marks = cells[~alike], marks[~alike]
        if size <= FINEST:
            parted = self.part(rest, marks, size)
            rest, marks = rest[~parted], marks[~parted]
        if size == 1:
            quarter = rest[:, None, None] + (SIDES[:, None] + SIDES) / 2.0
            polygon = np.concatenate([quarter, np.repeat(quarter[:, :, -1:], 4, axis=2)], axis=2)
            self.parts.append((polygon.reshape(-1, 8, 2), marks.ravel()))
        else:
            self.todo[size // 2].append((rest[:, None] + size // 2 * SIDES).reshape(-1, 2))
            if not len(rest):
                self.todo[size // 2].pop()

    def marks(self, place: Integers) -> Integers:
        """The marks at places (..., 2); rays are sent where there were none, and neighbours compared with them."""
        missing = np.unique(place[self.rays.at(place) < 0].reshape(-1, 2), axis=0)
        if len(missing):
            marks = self.sent(missing.astype(np.float64))
            self.rays.add(missing, marks)
            self.compare(missing, marks)
        return self.rays.at(place)

    def sent(self, place: Floats) -> Integers:
        parts = [met(place[low : low + AT_ONCE], self.picture, self.setting) for low in range(0, len(place), AT_ONCE)]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)

    def compare(self, place: Integers, marks: Integers) -> None:
        """Quarters whole cells on whose sides lie new rays of another mark."""
        for size in SIZES[:-1]:
            on = place % size == 0
            for axis in (0, 1):
                some = on[:, axis] & ~on[:, 1 - axis]
                if not some.any():
                    continue
                least = place[some] // size * size
                for back in (0, size):
                    cells = least.copy()
                    cells[:, axis] -= back
                    has = self.wholes[size].at(cells)
                    self.quarter(cells[(has >= 0) & (has != marks[some])], size)

    def quarter(self, cells: Integers, size: int) -> None:
        if len(cells):
            cells = np.unique(cells, axis=0)
            self.wholes[size].remove(cells)
            self.todo[size // 2].append((cells[:, None] + size // 2 * SIDES).reshape(-1, 2))

    def look_about(self, cells: Integers, marks: Integers, size: int) -> None:
        """Quarters new whole cells on whose sides lie rays of another mark."""
        if size == COARSE:
            return
        step = size // min(size, 4)
        along = step * np.arange(1, size // step)[:, None]
        on_sides = np.concatenate([SIDES[i] * size + along * (SIDES[(i + 1) % 4] - SIDES[i]) for i in range(4)])
        there = self.rays.at(cells[:, None] + on_sides)
        self.quarter(cells[((there >= 0) & (there != marks[:, None])).any(axis=1)], size)

    def part(self, cells: Integers, marks: Integers, size: int) -> NDArray[np.bool_]:
        """Parts cells in which two marks meet, one beside the other; returns which (M,) it did."""
        differ = marks != np.roll(marks, -1, axis=1)
        parted, able = np.zeros(len(cells), dtype=np.bool_), np.flatnonzero(differ.sum(axis=1) == 2)
        cells, marks, differ = cells[able], marks[able], differ[able]
        slots, straight = np.full((len(able), 8, 2), np.nan), np.ones(len(able), dtype=np.bool_)
        slots[:, ::2] = cells[:, None] + size * SIDES
        cell, side = np.nonzero(differ)
        ends = cells[cell][:, None] + size * np.stack([SIDES[side], SIDES[(side + 1) % 4]], axis=1)
        slots[cell, 2 * side + 1], sound = self.crossings(ends)
        np.logical_and.at(straight, cell, sound)
        one, other = slots[cell[::2], 2 * side[::2] + 1], slots[cell[1::2], 2 * side[1::2] + 1]
        middle = (cells + size / 2.0).astype(np.float64)
        away = cross(other - one, middle - one) / np.maximum(np.linalg.norm(other - one, axis=1), 1e-9)
        expected = np.where(
            away < 0.0, marks[np.arange(len(able)), (side[::2] + 1) % 4], marks[np.arange(len(able)), side[::2]]
        )
        straight &= (np.abs(away) < 0.1 * size) | (self.sent(middle) == expected)
        kept = straight if size > 1 else np.ones(len(able), dtype=np.bool_)
        for mark in (marks[np.arange(len(able)), side[::2]], marks[np.arange(len(able)), (side[::2] + 1) % 4]):
            present = np.zeros((len(able), 8), dtype=np.bool_)
            present[:, ::2], present[:, 1::2] = marks == mark[:, None], differ
            last = np.maximum.accumulate(np.where(present, np.arange(8), -1), axis=1)
            last = np.where(last < 0, last[:, -1:], last)
            self.parts.append((np.take_along_axis(slots, last[:, :, None], axis=1)[kept], mark[kept]))
        parted[able[kept]] = True
        return parted

    def crossings(self, ends: Integers) -> tuple[Floats, NDArray[np.bool_]]:
        """Where on sides with ends (M, 2, 2) one mark goes over into the other, and whether no third one is between."""
        swapped = key_of(ends[:, 0]) > key_of(ends[:, 1])
        ends = np.where(swapped[:, None, None], ends[:, ::-1], ends)
        ends, inverse = np.unique(ends.reshape(-1, 4), axis=0, return_inverse=True)
        ends = ends.reshape(-1, 2, 2)
        begin, way, inverse = (
            ends[:, 0].astype(np.float64),
            (ends[:, 1] - ends[:, 0]).astype(np.float64),
            inverse.reshape(-1),
        )
        low, high, here = np.zeros(len(ends)), np.ones(len(ends)), self.rays.at(ends[:, 0])
        beyond = there = self.rays.at(ends[:, 1])
        for _ in range(HALVINGS):
            half = (low + high) / 2.0
            mark = self.sent(begin + half[:, None] * way)
            near = mark == here
            low, high, beyond = np.where(near, half, low), np.where(near, high, half), np.where(near, beyond, mark)
        at = begin + ((low + high) / 2.0)[:, None] * way
        return at[inverse], (beyond == there)[inverse]

    def triangles(self) -> Iterator[tuple[Floats, Integers]]:
        """Triangles (M, 3, 2) of places, and their marks."""
        for size, whole in self.wholes.items():
            square = whole.places[:, None] + size * SIDES.astype(np.float64)
            for third in (2, 3):
                yield from lit_triangles(square[:, [0, third - 1, third]], whole.marks)
        for polygon, mark in self.parts:
            for third in range(2, 8):
                yield from lit_triangles(polygon[:, [0, third - 1, third]], mark)


def cross(one: Floats, other: Floats) -> Floats:
    """Of vectors (M, 2) in a plane (M,)."""
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def lit_triangles(corners: Floats, marks: Integers) -> Iterator[tuple[Floats, Integers]]:
    area = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    some = np.flatnonzero((marks > 0) & (np.abs(area) > 1e-12))
    yield corners[some], marks[some]


# ----------------------------------------------------------------------------------------------------------------------- fields


def add_fields(total: Complexes, first: float, corners: Floats, marks: Integers, picture: Picture, setting: Setting) -> None:
    """Adds to a profile what triangles (M, 3, 2) of a picture return."""
    mesh, eye = setting.mesh, np.broadcast_to(picture.frame[0], (len(marks), 3))
    ways = picture.ways(corners)
    field = polarized(unit(ways.mean(axis=1)), setting.polarization)
    for bounce in range(setting.bounces):
        plane = (marks >> (PLANE_BITS * bounce) & MASK) - 1
        there = np.flatnonzero(plane >= 0)
        marks, eye, ways, field, plane = marks[there], eye[there], ways[there], field[there], plane[there]
        normal, offset = mesh.plane_normal[plane], mesh.plane_offset[plane]
        height = offset - dots(normal, eye)
        normal, height = normal * -np.sign(height)[:, None], -np.abs(height)  # against the rays
        points = eye[:, None] + height[:, None, None] / np.einsum("mcx,mx->mc", ways, normal)[..., None] * ways
        for back, receiver in enumerate(setting.receivers):
            some = np.flatnonzero(marks >> (3 * PLANE_BITS + 2 * bounce + back) & 1)
            returned = returns(points[some], eye[some], field[some], normal[some], receiver, setting)
            for half_path, amplitude in returned:
                add(total[picture.by_sea + back], half_path - first, amplitude)
        eye = eye + 2.0 * height[:, None] * normal
        ways = ways - 2.0 * np.einsum("mcx,mx->mc", ways, normal)[..., None] * normal[:, None]
        field = 2.0 * dots(field, normal)[:, None] * normal - field


def add(total: Complexes, away: Floats, amplitude: Complexes) -> None:
    """Shares amplitudes among the bins about half paths from the first bin on."""
    place = away / FINE
    index = np.floor(place).astype(np.int64)
    for step, share in ((0, index + 1 - place), (1, place - index)):
        weighted = share * amplitude
        for part, numbers in (("real", weighted.real), ("imag", weighted.imag)):
            getattr(total, part)[:] += np.bincount(index + step, numbers, len(total))


def returns(
    points: Floats, eye: Floats, field: Floats, normal: Floats, receiver: Floats, setting: Setting
) -> Iterator[tuple[Floats, Complexes]]:
    """Half paths (M,) [m] and amplitudes (M,) [m] of triangles (M, 3, 3) that an eye (M, 3) lights, toward a receiver (3,)."""
    k = 2.0 * np.pi / setting.wavelength
    while len(points):
        path = np.linalg.norm(points - eye[:, None], axis=2) + np.linalg.norm(points - receiver, axis=2)
        edges = np.linalg.norm(points - np.roll(points, -1, axis=1), axis=2)
        row, edge = np.arange(len(points)), edges.argmax(axis=1)
        one, other, third = points[row, edge], points[row, (edge + 1) % 3], points[row, (edge + 2) % 3]
        half = (one + other) / 2.0
        bend = np.linalg.norm(half - eye, axis=1) + np.linalg.norm(half - receiver, axis=1)
        bend -= (path[row, edge] + path[row, (edge + 1) % 3]) / 2.0
        long = (np.ptp(path, axis=1) > 2.0 * RANGE) | (k * np.abs(bend) > SAG)
        yield triangle_returns(points[~long], path[~long], eye[~long], field[~long], normal[~long], receiver, setting)
        halves = np.concatenate([np.stack([one, half, third], axis=1)[long], np.stack([half, other, third], axis=1)[long]])
        points, eye, field, normal = halves, *(np.concatenate([a[long], a[long]]) for a in (eye, field, normal))


def triangle_returns(
    points: Floats, path: Floats, eye: Floats, field: Floats, normal: Floats, receiver: Floats, setting: Setting
) -> tuple[Floats, Complexes]:
    """The same of triangles over which phases are linear; path: of their corners (M, 3) [m]. The sum over edges of a triangle,
    where the phase is phi + a s + b t in its sides s, t from 0 to s + t = 1."""
    middle = points.mean(axis=1)
    travel, back = unit(middle - eye), unit(middle - receiver)
    received = polarized(back, setting.polarization)
    current = dots(received, travel) * dots(normal, field) - dots(received, field) * dots(normal, travel)
    area = np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1)
    phase = -2.0 * np.pi / setting.wavelength * path
    a, b = phase[:, 1] - phase[:, 0], phase[:, 2] - phase[:, 0]
    square = a**2 + b**2

    def edge(weight: Floats, turn: Floats, middle: Floats) -> Complexes:
        return np.asarray(weight * np.sinc(turn / (2.0 * np.pi)) * np.exp(1j * middle))

    edges = edge(-b, a, a / 2.0) + edge(a + b, b - a, (a + b) / 2.0) + edge(-a, b, b / 2.0)
    flat = 0.5 * np.exp(1j * (a + b) / 3.0)
    mean = np.where(square > 1e-8, edges / (1j * np.maximum(square, 1e-8)), flat) * np.exp(1j * phase[:, 0])
    amplitude = -2j * np.sqrt(np.pi) / setting.wavelength * current * area * mean
    return path.mean(axis=1) / 2.0, amplitude
