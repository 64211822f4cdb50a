"""Mesh quality for physical optics, as `check` reports it: facet sizes, concavity, sides, curvature; shared edges of a mesh."""

import math

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Flags, Floats
from radar_service.radar import Radar
from radar_service.world import Body, Mesh, mesh_sample, outward_winding

COPLANAR = 1e-6  # rad between normals: over a patch of 100 m a sag of 0.1 mm, a hundredth of a radian of two-way phase
LEVEL = 1e-4  # of the body's size: what rises less above a plane is the plane's own rounding or the sag of a fine mesh
SHEET = 1e-9  # of the volumes that its triangles could span: a closed part with less has only rounding, and is a sheet
DIRECTIONS = 512  # along which the outermost points of a body with more points are searched
Sides = NDArray[np.int8]
MAX_CURVE_BEND = math.radians(30.0)  # between facets: less may approximate a curve, more is an edge
MAX_SAG = 1.0 / 200.0  # of the wavelength, 0.16 mm at X band:
CURVES_DB = 0.2  # error of curves that sag so (world/shapes.py)


def shared_edges(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of edges that coincide, edge i of triangle f (from its corner i to the next) as 3 f + i."""
    ends = np.sort(_welded_edges(mesh)[0], axis=1)
    order = np.lexsort(ends.T)
    same = (np.diff(ends[order], axis=0) == 0).all(axis=1)
    return order[:-1][same], order[1:][same]


def _welded_edges(mesh: Mesh) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Ends (3 F, 2) of all edges, coinciding vertices counted as one, and the triangle of each. There may be millions."""
    _, where = np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)  # + 0.0: -0.0 and 0.0 are one position
    welded = where.reshape(-1).astype(np.int32)[mesh.faces]
    ends = np.stack([welded, np.roll(welded, -1, axis=1)], axis=2).reshape(-1, 2)
    return ends, np.repeat(np.arange(len(mesh.faces), dtype=np.int32), 3)


def _parts(ends: NDArray[np.int32], face: NDArray[np.int32], faces: int) -> tuple[NDArray[np.int64], int, NDArray[np.int32]]:
    """Numbers (3 F,) of edges, the same for those that coincide; how many parts there are, and of which each triangle is (F,)."""
    from scipy.sparse import coo_array  # here: only bodies by optics need it, and it would slow every start
    from scipy.sparse.csgraph import connected_components

    low, high = ends.min(axis=1), ends.max(axis=1)
    edge, uses = np.unique(low.astype(np.int64) * (int(high.max()) + 1) + high, return_inverse=True, return_counts=True)[1:]
    order = np.argsort(edge, kind="stable")
    face_a, face_b = face[order[uses[edge[order]] == 2]].reshape(-1, 2).T
    links = coo_array((np.ones(len(face_a)), (face_a, face_b)), shape=(faces, faces))
    count, part = connected_components(links, directed=False)
    return edge, count, part


def outward_side(mesh: Mesh) -> NDArray[np.int8]:
    """(F,) which side of each triangle is outside: 1 the one its winding faces, -1 the other, 0 where both may be seen.

    Known for parts that are closed: each of their edges runs both ways equally often, and their volume has a sign. Triangles are
    of one part where an edge joins two of them alone.
    """
    ends, face = _welded_edges(mesh)
    edge, count, part = _parts(ends, face, len(mesh.faces))
    key, place = np.unique(edge * count + part[face], return_inverse=True)
    balance = np.bincount(place, np.where(ends[:, 0] < ends[:, 1], 1.0, -1.0))
    is_open = np.bincount(key % count, balance != 0.0, minlength=count) > 0
    a, b, c = (mesh.vertices[mesh.faces[:, i]] - mesh.vertices.mean(axis=0) for i in range(3))
    across = np.cross(b, c)
    volumes, sizes = np.einsum("ij,ij->i", a, across), np.linalg.norm(a, axis=1) * np.linalg.norm(across, axis=1)
    volume, rounding = (np.bincount(part, v, minlength=count) for v in (volumes, SHEET * sizes))
    side = np.where(is_open | (np.abs(volume) <= rounding), 0.0, np.sign(volume))
    return np.asarray(side[part], dtype=np.int8)


def is_concave(mesh: Mesh) -> bool:
    """Whether parts of a mesh may face each other, as seen from where a wave may come."""
    return concave(mesh, outward_side(mesh)) > 0


def concave_sides(mesh: Mesh) -> Flags:
    """(F, 2) whether any part of the body rises before the front and before the back of each triangle's plane."""
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = cross / np.maximum(np.linalg.norm(cross, axis=1), 1e-300)[:, None]
    outer = _outermost(np.unique(mesh.used_vertices, axis=0))
    own = np.einsum("ij,ij->i", normal, corners[:, 0])
    margin = LEVEL * float(np.linalg.norm(np.ptp(outer, axis=0)))
    result = np.zeros((len(normal), 2), dtype=np.bool_)
    for first in range(0, len(normal), 4096):
        part = slice(first, first + 4096)
        height = normal[part] @ outer.T - own[part, None]
        result[part, 0], result[part, 1] = height.max(axis=1) > margin, height.min(axis=1) < -margin
    return result


def _outermost(points: Floats) -> Floats:
    """The points (V, 3) themselves where they are few, else those outermost in many directions."""
    if len(points) <= DIRECTIONS:
        return points
    turn = np.arange(DIRECTIONS) * np.pi * (3.0 - np.sqrt(5.0))
    up = 1.0 - (2.0 * np.arange(DIRECTIONS) + 1.0) / DIRECTIONS
    level = np.sqrt(1.0 - up * up)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), up], axis=1)
    chosen = [np.argmax(directions[i : i + 8] @ points.T, axis=1) for i in range(0, DIRECTIONS, 8)]
    return np.asarray(points[np.unique(np.concatenate(chosen))])


def mesh_quality(body: Body, radar: Radar, bounces: int, distance: float) -> list[str]:
    """Sentences about a body by physical optics at its least distance over the run [m]."""
    assert body.mesh is not None
    mesh, large = mesh_sample(body.mesh), list[str]()
    if mesh is body.mesh:
        outside = outward_side(mesh)
    else:
        outside = np.full(len(mesh.faces), outward_winding(body.mesh), dtype=np.int8)
        large = [f"these are remarks on {len(mesh.faces)} of {len(body.mesh.faces)} facets, in slices across the body"]
    corners, facing = mesh.vertices[mesh.faces], concave(mesh, outside)
    longest = float(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max())
    sentences = [f"optics: facets up to {longest:.3g} m long; {_concavity(facing, len(mesh.faces), bounces)}"]
    return sentences + _sides(outside) + _curves(mesh, radar) + large


def _concavity(facing: int, count: int, bounces: int) -> str:
    if not facing:
        return "convex: no facet reflects onto another"
    return f"concave: {facing} of {count} facets face others, up to {bounces} bounces are computed"


def _sides(outside: Sides) -> list[str]:
    """What is lit where the file does not tell the outside: nothing is lost, but inner walls can be lit too."""
    unknown = int(np.count_nonzero(outside == 0))
    if unknown == 0:
        return []
    return [
        f"{unknown} of {len(outside)} facets belong to parts that are open or wound both ways: both their sides reflect; close "
        "a hull, so that no inner wall reflects through a gap"
    ]


def concave(mesh: Mesh, outside: Sides) -> int:
    """How many triangles have a part of the body in front of an outer side of theirs; outside: (F,) as from `outward_side`."""
    may_rebounce = concave_sides(mesh)
    return int(np.count_nonzero((may_rebounce[:, 0] & (outside >= 0)) | (may_rebounce[:, 1] & (outside <= 0))))


def _curves(mesh: Mesh, radar: Radar) -> list[str]:
    sag, limit = curve_sag(mesh), MAX_SAG * radar.wavelength
    if sag == 0.0:
        return []
    if sag <= limit:
        return [f"curves sag by at most {length_text(sag)}, fine at a wavelength of {1e3 * radar.wavelength:.3g} mm"]
    return [
        f"bends below {math.degrees(MAX_CURVE_BEND):.0f} degrees, if they approximate curves, leave facets up to "
        f"{length_text(sag)} off them; beyond {1e3 * limit:.2g} mm, 1/200 of the wavelength, curves err by over 0.2 dB: refine "
        "those that matter"
    ]


def length_text(length: float) -> str:
    """A length [m] in words: in millimetres below a metre."""
    return f"{1e3 * length:.3g} mm" if length < 1.0 else f"{length:.3g} m"


def curve_sag(mesh: Mesh) -> float:
    """The greatest distance [m] of a facet from the curve that it and its neighbours approximate; 0 where nothing is curved.

    The sum over its edges of bend x height over the edge / 8: that of a strip of a cylinder, bent at both sides of its two
    triangles, exactly; of an equilateral triangle on a sphere 9/8 of e^2 / (6 r).
    """
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.maximum(np.linalg.norm(cross, axis=1), 1e-300)
    normal = cross / double[:, None]
    height = double[:, None] / np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    pairs = np.stack(shared_edges(mesh))
    normal_a, normal_b = normal[pairs // 3]
    bend = np.arcsin(np.minimum(np.linalg.norm(np.cross(normal_a, normal_b), axis=1), 1.0))  # whichever way each is wound
    curved = (bend > COPLANAR) & (bend < MAX_CURVE_BEND)
    sag = np.zeros(len(normal))
    for edge in pairs[:, curved]:
        np.add.at(sag, edge // 3, bend[curved] * height.ravel()[edge] / 8.0)
    return float(sag.max(initial=0.0))
