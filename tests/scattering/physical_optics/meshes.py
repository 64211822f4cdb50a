"""Conducting bodies written to mesh files by the test itself, at any tessellation and turned any way."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import radar_service as rs
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.model import OpticalBody
from radar_service.world.poses import MAP_POSE

Floats = NDArray[np.float64]
WAVELENGTH = 299_792_458.0 / 9.41e9
ODD = Rotation.from_euler("zxy", [37.3, -21.9, 11.7], degrees=True).as_matrix()  # no axis of a body meets one of the file


def sheet(corner: Any, one: Any, other: Any, n: int) -> Floats:
    """A parallelogram of 2 n^2 triangles (F, 3, 3)."""
    p, u, v = (np.asarray(x, dtype=float) for x in (corner, one, other))
    i, j = (g.ravel()[:, None] / n for g in np.meshgrid(np.arange(n), np.arange(n)))
    a, b, c, d = (p + (i + s) * u + (j + t) * v for s, t in ((0, 0), (1 / n, 0), (1 / n, 1 / n), (0, 1 / n)))
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def wedge(corner: Any, one: Any, other: Any, n: int) -> Floats:
    """A triangle at `corner` with sides `one` and `other`, of n^2 triangles."""
    p, u, v = (np.asarray(x, dtype=float) for x in (corner, one, other))
    up = [(i, j) for i in range(n) for j in range(n - i)]
    down = [(i, j) for i in range(n - 1) for j in range(n - 1 - i)]
    faces = [[(i, j), (i + 1, j), (i, j + 1)] for i, j in up]
    faces += [[(i + 1, j), (i + 1, j + 1), (i, j + 1)] for i, j in down]
    steps = np.array(faces, dtype=float) / n
    return np.asarray(p + steps[..., :1] * u + steps[..., 1:] * v)


def plate(width: float, height: float, n: int) -> Floats:
    """In the plane y = 0 about the origin."""
    return sheet([-width / 2, 0, -height / 2], [width, 0, 0], [0, 0, height], n)


def dihedral(a: float, b: float, n: int) -> Floats:
    """Two plates a wide, b high, along x and y from the fold on the z axis."""
    fold = [0, 0, -b / 2]
    return np.concatenate([sheet(fold, [a, 0, 0], [0, 0, b], n), sheet(fold, [0, a, 0], [0, 0, b], n)])


def trihedral(a: float, n: int, square: bool) -> Floats:
    """Three plates between the positive axes."""
    x, y, z = a * np.eye(3)
    face = sheet if square else wedge
    return np.concatenate([face([0, 0, 0], x, y, n), face([0, 0, 0], y, z, n), face([0, 0, 0], z, x, n)])


def sphere(radius: float, n: int) -> Floats:
    """A cube of 12 n^2 triangles blown up."""
    faces = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            one, other, out = np.eye(3)[axis], np.eye(3)[(axis + 1) % 3], side * np.eye(3)[(axis + 2) % 3]
            faces.append(sheet(out - one - other, 2 * one, 2 * other, n))
    points = np.tan(np.concatenate(faces) * np.pi / 4.0)  # evens out the size of the triangles
    return np.asarray(radius * points / np.linalg.norm(points, axis=2, keepdims=True))


def cylinder(radius: float, height: float, sides: int) -> Floats:
    """The mantle about the z axis, from -height / 2 up."""
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    ring = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(sides + 1, -height / 2)], 1)
    parts = [sheet(p, q - p, [0, 0, height], 1) for p, q in zip(ring[:-1], ring[1:], strict=True)]
    return np.concatenate(parts)


def write_stl(path: Path, triangles: Floats) -> None:
    """Binary STL: single precision, no shared corners."""
    record = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    record["v"] = triangles
    path.write_bytes(b"made by a test".ljust(80) + np.uint32(len(triangles)).tobytes() + record.tobytes())


def write_obj(path: Path, triangles: Floats) -> None:
    """OBJ text to a nanometre, every triangle with corners of its own."""
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in triangles.reshape(-1, 3)]
    lines += [f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}" for k in range(len(triangles))]
    path.write_text("\n".join(lines))


def loaded(folder: Path, triangles: Floats, kind: str = "obj", radar: dict[str, Any] | None = None, **body: Any) -> rs.Scene:
    """A scene of one body by optics, whose mesh goes through a file."""
    path = folder / f"mesh.{kind}"
    (write_stl if kind == "stl" else write_obj)(path, triangles)
    settings = {"range_max_m": 5000, **(radar or {})}
    made = {"name": "body", "mesh": path.name, "scattering": "optics", "position_m": [0, 1000, 0], **body}
    return rs.load_scene({"radar": settings, "environment": {"earth": "flat"}, "body": [made]}, folder=folder)


def optical(made: rs.Scene, bounces: int = 3) -> OpticalBody:
    """The first body of a scene, ready for optics."""
    return OpticalBody.of(made.bodies[0], made.radar, bounces)


def cross_section(body: OpticalBody, antenna: Floats) -> float:
    """Cross-section [m^2] toward an antenna (3,) in the body's frame, as the radar equation at the origin's range has it."""
    point, amplitude = echoes_toward(body, antenna)
    distance, origin = np.linalg.norm(point - antenna, axis=1), float(np.linalg.norm(antenna))
    turned = amplitude * np.exp(-2j * body.optics.wave.wavenumber * (distance - origin)) * (origin / distance) ** 2
    return float(abs(turned.sum()) ** 2)


def echoes_toward(body: OpticalBody, antenna: Floats) -> tuple[Floats, NDArray[np.complex128]]:
    """Phase centres and scattering amplitudes for one antenna (3,) that transmits and receives, in the body's frame."""
    (centres,) = body.echoes((direct(antenna),))
    return centres.position, centres.amplitude


def direct(antenna: Floats) -> BodyLeg:
    """The direct leg from an antenna (3,) in the body's frame, over a flat earth."""
    return BodyLeg(False, MAP_POSE, antenna, np.inf)


def areas(corners: Floats) -> Floats:
    """Areas (F,) of triangles (F, 3, 3)."""
    a, b, c = corners[..., :3].transpose(1, 0, 2)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0)


def toward(direction: Any, distance: float) -> Floats:
    """The position `distance` away in a direction (3,)."""
    d = np.asarray(direction, dtype=float)
    return np.asarray(distance * d / np.linalg.norm(d))


def decibels(power: float) -> float:
    """10 log10."""
    return float(10.0 * np.log10(power))
