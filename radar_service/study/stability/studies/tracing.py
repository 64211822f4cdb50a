"""Ray tracing: single precision, an absolute epsilon, slivers, shared edges, grazing incidence and wide maps."""

from collections.abc import Callable
from typing import Any

import numpy as np

from radar_service.numerics import Floats
from radar_service.propagation import two_way_phase
from radar_service.study.stability.finding import (
    WAVELENGTH,
    Axis,
    Curve,
    Expected,
    Finding,
    bisect,
    crossing,
    curve,
    decades,
    plain,
)
from radar_service.trace import (
    Occluder,
    OcclusionScene,
    SurfacePoints,
    TriangleScene,
    printed_crossings,
    watertight_crossings,
)
from radar_service.world import SHAPES, Body, BodyPose, Mesh, Motion, material_from_name

DISTANCE = 1000.0  # m from the origins of the rays to the small triangles
TOWARD = np.array([0.27, -0.94, 0.21])  # direction from the sphere to the origins of the rays
DEGREES_PER_METRE = np.longdouble(720.0) / np.longdouble(WAVELENGTH)  # of two-way phase


def float32_range(fine: int = 1) -> Finding:
    """Drives the range: two-way phase of a range in single and in double precision, against extended precision."""
    octaves = 2.0 ** np.arange(6.0, 18.0)
    rng = np.random.default_rng(1)
    single, double = [], []
    for start in octaves:
        r = np.asarray(start * (1.0 + rng.random(2000 * fine)), dtype=np.longdouble)
        single.append(float(np.abs((r.astype(np.float32).astype(np.longdouble) - r) * DEGREES_PER_METRE).max()))
        phase = np.angle(two_way_phase(r.astype(np.float64), WAVELENGTH), deg=True)
        exact = np.asarray((r * DEGREES_PER_METRE) % 360.0, dtype=np.float64)
        double.append(float(np.abs((phase + exact + 180.0) % 360.0 - 180.0).max()))
    failing = np.flatnonzero(np.array(single) > 1.0)
    return Finding(
        name="range in single precision",
        method="range in float32, the precision of Embree",
        setup="two-way phase of random ranges, in float32 and in float64",
        parameter=Axis("range [m]", log=True),
        values=plain(octaves),
        measured=Axis("largest phase error [degrees]", log=True),
        curves=(curve("float32", single), curve("the engine, float64", double)),
        limit=1.0,
        limit_reason="one degree of two-way phase at 9.41 GHz",
        boundary=float(octaves[failing[0]]),
        expected=Expected(1024.0, 0.0, "half a unit in the last place of 2^10 m is 30.5 um, 1.38 degrees; below it 0.69"),
        response="another method",
        instead="range and phase in float64",
        details="Embree only tells which triangle a ray hits. Range and phase are float64 at every distance.",
    )


def _triangle(first: float, second: float) -> Floats:
    """Returns the corners (1, 3, 3) [m] of a horizontal right triangle with these legs [m]."""
    return np.array([[[0.0, 0.0, 0.0], [first, 0.0, 0.0], [0.0, second, 0.0]]])


def _missed(corners: Floats, count: int, seed: int) -> tuple[float, float, float]:
    """Returns the shares of rays at inner points of a triangle that miss it: printed, watertight, Embree."""
    rng = np.random.default_rng(seed)
    share = np.sort(rng.random((count, 2)), axis=1)
    weights = np.stack([share[:, 0], share[:, 1] - share[:, 0], 1.0 - share[:, 1]], axis=1) * 0.98 + 0.02 / 3.0
    aim = weights @ corners[0]
    origin = np.column_stack([*(DISTANCE * 0.3 * (2.0 * rng.random((2, count)) - 1.0)), np.full(count, DISTANCE)])
    direction = (aim - origin) / np.linalg.norm(aim - origin, axis=1)[:, None]
    embree = TriangleScene(corners[0], np.array([[0, 1, 2]])).first_hit(origin, direction) < 0
    printed, watertight = (np.isinf(f(origin, direction, corners)) for f in (printed_crossings, watertight_crossings))
    return float(printed.mean()), float(watertight.mean()), float(embree.mean())


def triangle_size(fine: int = 1) -> Finding:
    """Drives the size of triangles: share of rays at their inner points that miss them."""
    return _of_triangles(
        decades(1e-6, 1e5, 2 * fine), lambda size: _triangle(size, size),
        name="small triangles",
        setup="rays from 1 km at inner points of right triangles of different size",
        parameter=Axis("legs of the triangle [m]", log=True),
        expected=Expected(1e-3, 0.05, "legs squared = epsilon 1e-6; rays up to 23 degrees off the normal see 4 % less"),
        details="Only `documented` with tracer moller_trumbore uses the epsilon. Embree aims in float32, so from 1 km it also "
        "misses triangles below a millimetre; the engine takes echoes from the surface, not from hits.",
    )  # fmt: skip


def sliver_width(fine: int = 1) -> Finding:
    """Drives the width of slivers: share of rays at inner points of triangles 10 m long that miss them."""
    return _of_triangles(
        decades(1e-9, 1.0, 2 * fine), lambda width: _triangle(10.0, width),
        name="thin triangles",
        setup="rays from 1 km at inner points of triangles 10 m long",
        parameter=Axis("width of a triangle 10 m long [m]", log=True),
        expected=Expected(1e-7, 0.05, "10 m x width = epsilon 1e-6"),
        details="A sliver that Embree misses occludes nothing. Its echo depends on its area and is kept.",
    )  # fmt: skip


def _of_triangles(sizes: Floats, triangle: Callable[[float], Floats], **fields: Any) -> Finding:
    """The shares of rays that miss triangles by their sizes, up to at least 1 m."""
    shares = np.array([_missed(triangle(size), 100, k) for k, size in enumerate(sizes)])
    return Finding(
        method="Moeller-Trumbore with an absolute epsilon of 1e-6, as printed",
        values=plain(sizes),
        measured=Axis("share of rays that miss [1]"),
        curves=_by_method(shares, "Embree"),
        limit=0.5,
        limit_reason="half of the rays miss",
        boundary=bisect(lambda size: _missed(triangle(size), 100, 0)[0] > 0.5, 1.0, sizes[0]),
        response="another method",
        instead="Embree for occlusion, scatterers on the surface for echoes",
        **fields,
    )


def _by_method(shares: Floats, embree: str) -> tuple[Curve, ...]:
    """Curves of shares (N, 3) of rays: printed, watertight, Embree."""
    return tuple(curve(name, share) for name, share in zip(("as printed", "watertight", embree), shares.T, strict=True))


def shared_edges(fine: int = 1) -> Finding:
    """Drives the distance of rays at the corners and edges of a closed sphere: share of rays that pass through it."""
    mesh = SHAPES["sphere"](1.0)
    corners, scene = mesh.vertices[mesh.faces], TriangleScene(mesh.vertices, mesh.faces)
    distances = decades(10.0, 1e4, fine)
    rng = np.random.default_rng(3)
    leaks = []
    for distance in distances:
        facing = np.flatnonzero((corners @ TOWARD).min(axis=1) > 0.5)  # well inside the outline
        face, share = rng.choice(facing, 150), rng.random((150, 1))
        share[::2] = 0.0  # every other ray aims at a corner
        aim = corners[face, 0] * (1.0 - share) + corners[face, 1] * share
        origin = TOWARD * distance + rng.normal(0.0, 1e-3, (150, 3)) * distance
        ray = (aim - origin) / np.linalg.norm(aim - origin, axis=1)[:, None]
        missed = [np.isinf(f(origin, ray, corners)).all(axis=1) for f in (printed_crossings, watertight_crossings)]
        leaks.append([*(float(m.mean()) for m in missed), float((scene.first_hit(origin, ray) < 0).mean())])
    shares = np.array(leaks)
    return Finding(
        name="shared edges and corners",
        method="Moeller-Trumbore as printed, and Embree in its robust mode",
        setup="rays at corners and edges of a closed sphere of 1 m radius",
        parameter=Axis("distance [m]", log=True),
        values=plain(distances),
        measured=Axis("share of rays that pass through [1]"),
        curves=_by_method(shares, "Embree, robust"),
        limit=1e-3,
        limit_reason="one ray in a thousand passes",
        boundary=crossing(distances, shares[:, 0], 1e-3, log=True),
        expected=Expected(None),
        response="no failure",
        instead="Embree in its robust mode",
        details="Embree runs in its robust mode. A leak would let a single line of sight pass.",
    )


def grazing_line_of_sight(fine: int = 1) -> Finding:
    """Drives the grazing angle: share of points on flat ground that their own ground occludes by mistake."""
    east, north = np.meshgrid(np.linspace(-50, 50, 5), np.linspace(100, 2100, 41))
    vertices = np.column_stack([east.ravel(), north.ravel(), np.zeros(east.size)])
    k = (np.arange(40)[:, None] * 5 + np.arange(4)).ravel()
    faces = np.concatenate([np.stack([k, k + 1, k + 6], axis=1), np.stack([k, k + 6, k + 5], axis=1)])
    ground, rng = Occluder(Mesh(vertices, faces), np.inf), np.random.default_rng(4)
    angles = decades(1e-7, 1e-1, 2 * fine)[::-1]
    occluded = []
    for angle in angles:
        triangle = rng.integers(0, len(faces), 2000 * fine)
        weights = rng.dirichlet((1.0, 1.0, 1.0), len(triangle))
        point = np.einsum("ij,ijk->ik", weights, vertices[faces[triangle]])
        antenna = np.array([0.0, 0.0, 1100.0 * np.tan(angle)])
        own = (triangle, triangle + 1)
        occluded.append(float(ground.self_occluded(BodyPose(np.zeros(3), 0.0), antenna, point, own).mean()))
    shares = np.array(occluded)
    return Finding(
        name="grazing incidence",
        method="line of sight past the triangles of the same surface",
        setup="lines of sight to points on flat ground, 100 to 2100 m away",
        parameter=Axis("grazing angle [rad]", log=True),
        values=plain(angles),
        measured=Axis("share occluded by mistake [1]"),
        curves=(curve("lines of sight", shares),),
        limit=1e-3,
        limit_reason="one point in a thousand",
        boundary=crossing(1.0 / angles, shares, 1e-3, log=True),
        expected=Expected(None),
        response="no failure",
        instead="a check of Embree's result in float64",
        details="Embree only names a triangle that may occlude. The engine decides in float64 whether it does.",
    )


def _body_at_rest(mesh: Mesh, east: float, north: float) -> Body:
    motion = Motion(np.zeros(1), np.array([[east, north, 0.0]]), np.zeros(1))
    return Body("study", mesh, motion, material_from_name("steel", "study"), "diffuse", None, 0, None, 2.0, 2.0)


def visibility_error(distance: float) -> float:
    """Returns the share of points of a sphere with wrong visibility when another body rests at `distance` [m].

    The sphere has 1 m radius and is 300 m away; faces within 3 degrees of its outline do not count."""
    mesh = SHAPES["sphere"](1.0)
    bodies = [_body_at_rest(mesh, 0.0, 300.0), _body_at_rest(mesh, distance * 0.8, distance * 0.6)]
    corners = mesh.vertices[mesh.faces]
    centre = corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    antenna, position = np.array([0.0, 0.0, 15.0]), centre + bodies[0].motion.position[0]
    line = antenna - position
    cosine = np.einsum("ij,ij->i", line, normal) / np.linalg.norm(line, axis=1) / np.linalg.norm(normal, axis=1)
    points = SurfacePoints(np.zeros(len(centre), dtype=np.int64), np.arange(len(centre)), position)
    above, clear = position[:, 2] >= 0.0, np.abs(cosine) > np.sin(np.deg2rad(3.0))
    visible = OcclusionScene(bodies, np.inf).visible(points, antenna, 0.0, 1e4)
    return float((visible != (cosine > 0.0))[above & clear].mean())


def wide_maps(fine: int = 1) -> Finding:
    """Drives the distance of a second body at rest in the same Embree scene: visibility of the first body."""
    distances = decades(1e3, 2e6, 4 * fine)
    shares = np.array([visibility_error(distance) for distance in distances])
    return Finding(
        name="large coordinates",
        method="one float32 tree for all bodies at rest",
        setup="visibility of a sphere of 1 m radius while another body rests far away",
        parameter=Axis("distance of the other body [m]", log=True),
        values=plain(distances),
        measured=Axis("share of wrong visibility [1]"),
        curves=(curve("lines of sight", shares),),
        limit=0.01,
        limit_reason="one hundredth of the surface",
        boundary=crossing(distances, shares, 0.01, log=True),
        expected=Expected(
            150e3, 0.35, "measured 157 km: 2^-24 of half of it, 5 mm, over 2 mm of slack; the service warns from 150 km"
        ),
        response="warning",
        instead="a warning for bodies at rest more than 150 km apart",
        details="All bodies at rest share one tree in float32. The service warns of scenes whose bodies at rest are more than "
        "150 km apart.",
    )


STUDIES = (float32_range, triangle_size, sliver_width, shared_edges, grazing_line_of_sight, wide_maps)
