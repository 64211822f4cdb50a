"""Where tracing fails: single precision over distance, the absolute epsilon, slivers, shared edges, grazing, wide maps."""

import numpy as np

from radar_service.propagation.radar_equation import two_way_phase
from radar_service.scene.body import Body, Mesh
from radar_service.scene.materials import material_from_name
from radar_service.scene.motion import Motion
from radar_service.scene.shapes import SHAPES
from radar_service.study.stability.finding import Axis, Finding, bisected, crossing, curve, decades, places
from radar_service.trace.embree import TriangleScene
from radar_service.trace.line_of_sight import Floats, OcclusionScene, Surface
from radar_service.trace.moller_trumbore import printed_crossings, watertight_crossings
from radar_service.trace.occluder import BodyPose, Occluder

WAVELENGTH = 299_792_458.0 / 9.41e9
FAR = 1000.0  # m from which small triangles are looked at
TOWARD = np.array([0.27, -0.94, 0.21])  # where the sphere is looked at from


def float32_range(fine: int = 1) -> Finding:
    """Two-way phase of a range kept in single and in double precision, against extended precision."""
    octaves = 2.0 ** np.arange(6.0, 18.0)
    rng = np.random.default_rng(1)
    single, double = [], []
    for start in octaves:
        r = np.asarray(start * (1.0 + rng.random(2000 * fine)), dtype=np.longdouble)
        turn = np.longdouble(720.0) / np.longdouble(WAVELENGTH)  # degrees to a metre
        single.append(float(np.abs((r.astype(np.float32).astype(np.longdouble) - r) * turn).max()))
        phase = np.angle(two_way_phase(r.astype(np.float64), WAVELENGTH), deg=True)
        double.append(float(np.abs(_wrapped_deg(phase + np.asarray((r * turn) % 360.0, dtype=np.float64))).max()))
    worst = np.array(single)
    return Finding(
        "float32 range", "a range in single precision (as Embree has it) and in double (as the engine has it)",
        Axis("range [m]", log=True), places(octaves), Axis("greatest phase error [degrees]", log=True),
        (curve("single precision", single), curve("the engine", double)), 1.0, "a degree of two-way phase at 9.41 GHz",
        float(octaves[np.flatnonzero(worst > 1.0)[0]]), "computes right",
        "Embree only says which triangle; range and phase are double precision at every distance.",
    )  # fmt: skip


def _wrapped_deg(angle: Floats) -> Floats:
    return (angle + 180.0) % 360.0 - 180.0


def _triangle(first: float, second: float) -> Floats:
    """Corners (1, 3, 3) of a right triangle with these legs, face up."""
    return np.array([[[0.0, 0.0, 0.0], [first, 0.0, 0.0], [0.0, second, 0.0]]])


def _missed(corners: Floats, count: int, seed: int) -> tuple[float, float, float]:
    """Shares of rays aimed at inner points of a triangle from FAR that miss it: printed, watertight, Embree."""
    rng = np.random.default_rng(seed)
    share = np.sort(rng.random((count, 2)), axis=1)
    weights = np.stack([share[:, 0], share[:, 1] - share[:, 0], 1.0 - share[:, 1]], axis=1) * 0.98 + 0.02 / 3.0
    aim = weights @ corners[0]
    origin = np.column_stack([*(FAR * 0.3 * (2.0 * rng.random((2, count)) - 1.0)), np.full(count, FAR)])
    direction = (aim - origin) / np.linalg.norm(aim - origin, axis=1)[:, None]
    embree = TriangleScene(corners[0], np.array([[0, 1, 2]])).first_hit(origin, direction) < 0
    printed, tight = (np.isinf(f(origin, direction, corners)) for f in (printed_crossings, watertight_crossings))
    return float(printed.mean()), float(tight.mean()), float(embree.mean())


def triangle_size(fine: int = 1) -> Finding:
    """Rays at the inside of ever smaller triangles, from a kilometre away."""
    sizes = decades(1e-6, 1e5, 2 * fine)
    shares = np.array([_missed(_triangle(size, size), 100, k) for k, size in enumerate(sizes)])
    edge = bisected(lambda size: _missed(_triangle(size, size), 100, 0)[0] > 0.5, 1.0, 1e-6)
    return Finding(
        "epsilon against triangle size", "Moeller-Trumbore as printed (absolute epsilon 1e-6), its scale-free form, Embree",
        Axis("legs of a right triangle [m]", log=True), places(sizes), Axis("share of rays missing [1]"),
        (curve("printed", shares[:, 0]), curve("watertight", shares[:, 1]), curve("Embree", shares[:, 2])), 0.5,
        "half of the rays at its inside miss it", edge, "falls back",
        "Only documented with tracer moller_trumbore uses the epsilon; the engine asks Embree (float32 aims: from 1 km "
        "it misses what is below a millimetre too) and takes what scatters from the surface, not from hits.",
    )  # fmt: skip


def sliver_width(fine: int = 1) -> Finding:
    """The same with triangles 10 m long and ever thinner."""
    widths = decades(1e-9, 1.0, 2 * fine)
    shares = np.array([_missed(_triangle(10.0, width), 100, k) for k, width in enumerate(widths)])
    edge = bisected(lambda width: _missed(_triangle(10.0, width), 100, 0)[0] > 0.5, 1.0, 1e-9)
    return Finding(
        "epsilon against slivers", "the same on triangles 10 m long and ever thinner",
        Axis("width of a sliver 10 m long [m]", log=True), places(widths), Axis("share of rays missing [1]"),
        (curve("printed", shares[:, 0]), curve("watertight", shares[:, 1]), curve("Embree", shares[:, 2])), 0.5,
        "half of the rays at its inside miss it", edge, "falls back",
        "As above. A sliver that Embree misses hides nothing; what it scatters goes by its area and is kept.",
    )  # fmt: skip


def shared_edges(fine: int = 1) -> Finding:
    """Rays at the very corners and edges of a closed sphere: how many slip through."""
    mesh = SHAPES["sphere"](1.0)
    corners, scene = mesh.vertices[mesh.faces], TriangleScene(mesh.vertices, mesh.faces)
    distances = decades(10.0, 1e4, fine)
    rng = np.random.default_rng(3)
    leaks = []
    for distance in distances:
        seen = np.flatnonzero((corners @ TOWARD).min(axis=1) > 0.5)  # well inside the outline
        face, share = rng.choice(seen, 150), rng.random((150, 1))
        share[::2] = 0.0  # every other ray goes for a corner
        aim = corners[face, 0] * (1.0 - share) + corners[face, 1] * share
        origin = TOWARD * distance + rng.normal(0.0, 1e-3, (150, 3)) * distance
        ray = (aim - origin) / np.linalg.norm(aim - origin, axis=1)[:, None]
        missed = [np.isinf(f(origin, ray, corners)).all(axis=1) for f in (printed_crossings, watertight_crossings)]
        leaks.append([*(float(m.mean()) for m in missed), float((scene.first_hit(origin, ray) < 0).mean())])
    shares = np.array(leaks)
    return Finding(
        "shared edges and corners", "rays at corners and edges of a closed sphere of 1 m",
        Axis("distance [m]", log=True), places(distances), Axis("share of rays leaking [1]"),
        (curve("printed", shares[:, 0]), curve("watertight", shares[:, 1]), curve("Embree, robust", shares[:, 2])), 1e-3,
        "a thousandth leaks", crossing(distances, shares[:, 0], 1e-3, log=True), "computes right",
        "Embree runs in its robust mode; a leak would only let one sight line past.",
    )  # fmt: skip


def grazing_sight(fine: int = 1) -> Finding:
    """Points on flat ground seen at ever smaller grazing angles: how many their own ground hides."""
    east, north = np.meshgrid(np.linspace(-50, 50, 5), np.linspace(100, 2100, 41))
    vertices = np.column_stack([east.ravel(), north.ravel(), np.zeros(east.size)])
    k = (np.arange(40)[:, None] * 5 + np.arange(4)).ravel()
    faces = np.concatenate([np.stack([k, k + 1, k + 6], axis=1), np.stack([k, k + 6, k + 5], axis=1)])
    ground, rng = Occluder(Mesh(vertices, faces), np.inf), np.random.default_rng(4)
    angles = decades(1e-7, 1e-1, 2 * fine)[::-1]
    hidden = []
    for angle in angles:
        triangle = rng.integers(0, len(faces), 2000 * fine)
        weights = rng.dirichlet((1.0, 1.0, 1.0), len(triangle))
        spot = np.einsum("ij,ijk->ik", weights, vertices[faces[triangle]])
        antenna = np.array([0.0, 0.0, 1100.0 * np.tan(angle)])
        own = (triangle, triangle + 1)
        hidden.append(float(ground.self_occluded(BodyPose(np.zeros(3), 0.0), antenna, spot, own).mean()))
    shares = np.array(hidden)
    return Finding(
        "grazing incidence", "sight of points on flat ground, 100 to 2100 m away, past the ground's own triangles",
        Axis("grazing angle [rad]", log=True), places(angles), Axis("share wrongly hidden [1]"),
        (curve("sight lines", shares),), 1e-3, "a thousandth of the points",
        crossing(1.0 / angles, shares, 1e-3, log=True), "computes right",
        "Embree only names a suspect; whether it stands in between is decided in double precision.",
    )  # fmt: skip


def _standing(mesh: Mesh, east: float, north: float) -> Body:
    motion = Motion(np.zeros(1), np.array([[east, north, 0.0]]), np.zeros(1))
    return Body("study", mesh, motion, material_from_name("steel", "study"), "diffuse", None, 0, None, 2.0, 2.0)


def wrongly_seen(far: float) -> float:
    """Share of the points of a sphere of 1 m, 300 m off, whose visibility is wrong when another body rests `far` [m] away.

    A convex body shows exactly the faces turned to the antenna; those within 3 degrees of the outline do not count.
    """
    mesh = SHAPES["sphere"](1.0)
    bodies = [_standing(mesh, 0.0, 300.0), _standing(mesh, far * 0.8, far * 0.6)]
    spot = mesh.vertices[mesh.faces].mean(axis=1)
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    antenna, place = np.array([0.0, 0.0, 15.0]), spot + bodies[0].motion.position[0]
    sight = antenna - place
    cosine = np.einsum("ij,ij->i", sight, normal) / np.linalg.norm(sight, axis=1) / np.linalg.norm(normal, axis=1)
    surface = Surface(np.zeros(len(spot), dtype=np.int64), np.arange(len(spot)))
    above, clear = place[:, 2] >= 0.0, np.abs(cosine) > np.sin(np.deg2rad(3.0))
    seen = OcclusionScene(bodies, np.inf).visible(surface, place, antenna, 0.0, 1e4)
    return float((seen != (cosine > 0.0))[above & clear].mean())


def wide_maps(fine: int = 1) -> Finding:
    """A body seen while another one at rest, in the same Embree scene, stands ever farther away."""
    distances = decades(1e3, 2e6, 4 * fine)
    shares = np.array([wrongly_seen(distance) for distance in distances])
    return Finding(
        "large coordinates", "visibility of a sphere of 1 m when another body at rest stands far away",
        Axis("distance of the other body [m]", log=True), places(distances), Axis("share judged wrongly [1]"),
        (curve("sight lines", shares),), 0.01, "a hundredth of the surface",
        crossing(distances, shares, 0.01, log=True), "warns",
        "Bodies at rest share one single-precision tree. A scene with bodies at rest more than 150 km apart is warned of.",
    )  # fmt: skip
