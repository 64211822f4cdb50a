"""Slow reference: metal meshes of any shape by physical optics, by brute force, sharing no code with the engine.

A grid of narrow beams, some millimetres wide at the body, leaves the antenna, and over the sea also its image. A ray drawn
in each beam says by first hits which surfaces the beam meets in a row. The beam itself is unfolded at their planes: its
footprint on the last one is a parallelogram, whose currents are integrated in closed form with the phase at the beam's
middle. So everything is exact but the rims of what is lit. Beams that meet other surfaces than one of their neighbours are
therefore parted into FINER^2, so that errors at rims, which are drawn, fall with the width of these. Convergence is shown by
two widths. All ways out and back are launched: direct, by the sea, and each order of both.

Author: this project, from J = 2 n x H (Knott, Shaeffer, Tuley 1985) and geometrical optics at all but the last surface. The earth
is flat. Phases follow exp(+j w t); positions are in a frame with z up [m].
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

LIGHT = 299_792_458.0
AT_ONCE = 400_000  # beams of a pass: some 300 MB
RISE = 1e-6  # of the mesh's extent, by which a ray starts off a surface, for Embree's numbers of 24 bits
FINER = 5  # times narrower are beams at rims
FINE = 0.02  # m of the bins of half paths, shared linearly: rounded to bins near half a wave, fields would err in step with them


class Mirrored(NamedTuple):
    """Beams (M,) unfolded: image of the antenna, and the images of their axes (M, 3); field: at the last surface (M, 3)."""

    eye: Floats
    ahead: Floats
    across: Floats
    up: Floats
    field: Floats

    def at(self, normal: Floats, offset: Floats) -> "Mirrored":
        """The image in planes with unit normals (M, 3) at offsets (M,)."""
        eye = self.eye - 2.0 * (dots(self.eye, normal) - offset)[:, None] * normal
        axes = [axis - 2.0 * dots(axis, normal)[:, None] * normal for axis in (self.ahead, self.across, self.up)]
        return Mirrored(eye, axes[0], axes[1], axes[2], 2.0 * dots(self.field, normal)[:, None] * normal - self.field)

    def chosen(self, which: NDArray[np.int64]) -> "Mirrored":
        return Mirrored(*(column[which] for column in self))


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
        self.plane = np.unique(planes, axis=0, return_inverse=True)[1].reshape(-1)
        self.rise = RISE * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
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
    """Beams (M,) on their way: unfolded; place: in the grid (2, M) [rad]; begin, direction: of the ray drawn in each (M, 3);
    number: of each in the grid (M,)."""

    unfolded: Mirrored
    place: Floats
    begin: Floats
    direction: Floats
    number: NDArray[np.int64]

    def chosen(self, which: NDArray[np.int64]) -> "Beams":
        return Beams(
            self.unfolded.chosen(which), self.place[:, which], self.begin[which], self.direction[which], self.number[which]
        )


class Returns(NamedTuple):
    """What beams return: the number of each, how many of its ways go by the sea, half the path [m], amplitude [m]."""

    number: NDArray[np.int64]
    ways: NDArray[np.int64]
    half_path: Floats
    amplitude: Complexes


@dataclass(frozen=True)
class Setting:
    """mesh: what is lit; receivers: the antenna (3,), over the sea also its image; water: height of the sea; bounces: most
    surfaces in a row; wavelength [m]; polarization: "h" or "v"."""

    mesh: Mesh
    receivers: list[Floats]
    water: float | None
    bounces: int
    wavelength: float
    polarization: str


def profile(
    triangles: Floats, antenna: Floats, width: float, bounces: int = 3, polarization: str = "h",
    water: float | None = None, wavelength: float = LIGHT / 9.41e9, seed: int = 1,
) -> Profile:  # fmt: skip
    """What a mesh returns to an antenna (3,). width: of beams at the mesh [m]; water: height of the sea; None: there is none."""
    mesh, rng = Mesh(triangles, water), np.random.default_rng(seed)
    receivers = [antenna] if water is None else [antenna, antenna * (1, 1, -1) + (0, 0, 2.0 * water)]
    setting = Setting(mesh, receivers, water, bounces, wavelength, polarization)
    away = np.linalg.norm(mesh.corners - antenna, axis=2)
    first, span = float(away.min()) - 50.0, 4.0 * float(np.ptp(away)) + 100.0
    total = np.zeros((3, int(span / FINE)), dtype=np.complex128)
    for by_sea, eye in enumerate(receivers):
        ahead = unit(mesh.middle - eye)
        across = unit(np.cross(ahead, [0.0, 0.0, 1.0]))
        frame = np.array([eye, ahead, across, np.cross(across, ahead)])
        step = width / float(np.linalg.norm(mesh.middle - eye))
        seen = (mesh.corners.reshape(-1, 3) - eye) @ frame[1:].T
        low, high = np.floor((s := seen[:, 1:] / seen[:, :1]).min(axis=0) / step), np.ceil(s.max(axis=0) / step)
        side = int(AT_ONCE**0.5)
        for corner in np.ndindex(*(int(n) for n in np.ceil((high - low) / side))):
            tile = np.arange(side + 2) - 1  # with a rim of one beam, to compare with
            grid = np.array(np.meshgrid(low[0] + side * corner[0] + tile, low[1] + side * corner[1] + tile)) + 0.5
            marks, returned = followed(grid.reshape(2, -1), frame, step, by_sea, setting, rng)
            at_rim, inner = rims(marks.reshape(side + 2, side + 2)), np.zeros((side + 2, side + 2), dtype=np.bool_)
            inner[1:-1, 1:-1] = True
            add(total, returned, first, (inner & ~at_rim).ravel())
            parted = grid[:, inner & at_rim]
            parts = (np.array(np.meshgrid(*2 * [np.arange(FINER)])).reshape(2, 1, -1) + 0.5) / FINER - 0.5
            fine = (parted[:, :, None] + parts).reshape(2, -1) * FINER
            for begin in range(0, fine.shape[1], AT_ONCE):
                add(
                    total,
                    followed(fine[:, begin : begin + AT_ONCE], frame, step / FINER, by_sea, setting, rng)[1],
                    first,
                )
    return Profile(first, total)


def rims(marks: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which of marks (N, M) differ from one of their eight neighbours."""
    result = np.zeros(marks.shape, dtype=np.bool_)
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        other = np.roll(marks, (down, right), axis=(0, 1))
        differs = marks != other
        result |= differs | np.roll(differs, (-down, -right), axis=(0, 1))
    return result


def add(total: Complexes, returned: list[Returns], first: float, kept: NDArray[np.bool_] | None = None) -> None:
    """Adds returns to a profile; kept: of which beams."""
    for part in returned:
        which = slice(None) if kept is None else kept[part.number]
        place = (part.half_path[which] - first) / FINE
        index = np.floor(place).astype(np.int64)
        for step, share in ((0, index + 1 - place), (1, place - index)):
            np.add.at(total, (part.ways[which], index + step), share * part.amplitude[which])


def followed(
    grid: Floats, frame: Floats, step: float, by_sea: int, setting: Setting, rng: np.random.Generator
) -> tuple[NDArray[np.int64], list[Returns]]:
    """What beams (M,) at places (2, M) of a grid meet: a mark (M,) of it, and what they return. frame: eye and axes (4, 3);
    step: of the grid [rad]."""
    mesh, result, marks = setting.mesh, [], np.zeros(grid.shape[1], dtype=np.int64)
    beams = launched(frame, step, grid, setting.polarization, rng)
    if by_sea and setting.water is not None:
        beams = risen(beams, mesh, setting.receivers[0], setting.water)
    for _ in range(setting.bounces):
        beams, normal, plane = arrived(beams, mesh)
        if not len(normal):
            break
        marks[beams.number] = marks[beams.number] * 7919 + plane + 1
        for back, receiver in enumerate(setting.receivers):
            clear = dots(receiver - beams.begin, normal) > 0.0
            clear &= reached(beams.begin, mesh, receiver, setting.receivers[0], setting.water if back else None)
            some = np.flatnonzero(clear)
            marks[beams.number[some]] += (back + 1) * 1_000_003
            seen = beams.chosen(some)
            ways = np.full(len(some), by_sea + back)
            result.append(Returns(seen.number, ways, *returns(seen, step, normal[some], receiver, setting)))
        offset = dots(normal, beams.begin)
        turned = beams.direction - 2.0 * dots(beams.direction, normal)[:, None] * normal
        unfolded, begin = beams.unfolded.at(normal, offset), beams.begin + mesh.rise * normal
        beams = Beams(unfolded, beams.place, begin, turned, beams.number)
    return marks, result


def launched(frame: Floats, step: float, grid: Floats, polarization: str, rng: np.random.Generator) -> Beams:
    """Beams at places (2, M) of a grid, in each of which a ray is drawn; frame, step: as of `followed`."""

    def along(place: Floats) -> Floats:
        return unit(frame[1] + place[0][:, None] * frame[2] + place[1][:, None] * frame[3])

    place, drawn = step * grid, step * (grid + rng.random(grid.shape) - 0.5)
    middle = along(place)
    eye, ahead, across, up = (np.broadcast_to(axis, middle.shape) for axis in frame)
    return Beams(
        Mirrored(eye, ahead, across, up, polarized(middle, polarization)), place, eye, along(drawn), np.arange(len(middle))
    )


def risen(beams: Beams, mesh: Mesh, antenna: Floats, water: float) -> Beams:
    """Beams of the image, where they rise from the sea: those whose ray gets down to it."""
    foot = beams.begin + beams.direction * ((water - beams.begin[:, 2]) / beams.direction[:, 2])[:, None] + (0, 0, mesh.rise)
    down = (beams.direction[:, 2] > 0.0) & mesh.clear(foot, np.broadcast_to(antenna, foot.shape))
    return beams._replace(begin=foot).chosen(np.flatnonzero(down))


def arrived(beams: Beams, mesh: Mesh) -> tuple[Beams, Floats, NDArray[np.int64]]:
    """Beams that meet something, with the points where they do as their begins, its normals (M, 3) against them, and planes."""
    hit = mesh.first_hit(beams.begin, beams.direction)
    beams, hit = beams.chosen(np.flatnonzero(hit >= 0)), hit[hit >= 0]
    facing = dots(mesh.normal[hit], beams.direction)
    along = (mesh.offset[hit] - dots(mesh.normal[hit], beams.begin)) / facing
    begin = beams.begin + along[:, None] * beams.direction
    return beams._replace(begin=begin), -np.sign(facing)[:, None] * mesh.normal[hit], mesh.plane[hit]


def reached(point: Floats, mesh: Mesh, receiver: Floats, antenna: Floats, water: float | None) -> NDArray[np.bool_]:
    """Whether nothing lies between points (M, 3) and a receiver, which with `water` is the antenna's image in it."""
    begin = point + mesh.rise * unit(receiver - point)
    if water is None:
        return mesh.clear(begin, np.broadcast_to(receiver, begin.shape))
    foot = point + (receiver - point) * ((water - point[:, 2]) / (receiver - point)[:, 2])[:, None] + (0, 0, mesh.rise)
    return mesh.clear(begin, foot) & mesh.clear(foot, np.broadcast_to(antenna, foot.shape))


def returns(beams: Beams, step: float, normal: Floats, receiver: Floats, setting: Setting) -> tuple[Floats, Complexes]:
    """Half paths (M,) [m] and amplitudes (M,) [m] of what beams leave where they arrive toward a receiver (3,)."""
    unfolded, (u, v), offset = beams.unfolded, beams.place, dots(normal, beams.begin)
    way = unfolded.ahead + u[:, None] * unfolded.across + v[:, None] * unfolded.up
    along = (offset - dots(normal, unfolded.eye)) / dots(normal, way)
    point = unfolded.eye + along[:, None] * way
    axes = (unfolded.across, unfolded.up)
    sides = [step * along[:, None] * (axis - (dots(normal, axis) / dots(normal, way))[:, None] * way) for axis in axes]
    area = np.linalg.norm(np.cross(*sides), axis=1)
    travel, back = unit(way), unit(point - receiver)
    path = along * np.linalg.norm(way, axis=1) + np.linalg.norm(point - receiver, axis=1)
    for side in sides:
        area = area * np.sinc(dots(travel + back, side) / setting.wavelength)
    received = polarized(back, setting.polarization)
    current = dots(received, travel) * dots(normal, unfolded.field) - dots(received, unfolded.field) * dots(normal, travel)
    amplitude = -2j * np.sqrt(np.pi) / setting.wavelength * current * area * np.exp(-2j * np.pi / setting.wavelength * path)
    return path / 2.0, amplitude
