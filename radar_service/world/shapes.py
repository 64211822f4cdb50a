"""Built-in shapes as triangle meshes in their own frame: heading 0, x east, y north (ahead), z up; normals face outward.

The origin is the centre of sphere and plate, the apex of the trihedral, the middle of the dihedral's fold, and the foot of
box, cylinder and hull (docs/scenes.md#shapes). A plate faces +y; dihedral and trihedral open toward +y, axis of symmetry
level.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from radar_service.numerics import Floats, Indices
from radar_service.world.body import Mesh

SAG = 0.004  # m between facet and curve: an eighth of an X-band wavelength, Rayleigh's limit for a smooth surface
_MAX_SPLITS = 6  # 81 920 triangles
_MAX_SIDES = 2048
_MAX_FINE_SIDES = 4096  # of a cylinder of a given sag: at 1/400 wavelength enough for radii up to 7600 wavelengths
# A sphere with n parts to an edge of the icosahedron has 20 n^2 triangles, which sag by at most 0.292 r / n^2.
_PARTS_SAG = 0.292
_MIN_PARTS, _MAX_PARTS = 4, 80  # 80: 1/300 wavelength up to a radius of 73 wavelengths, 1/100 up to 219


def shape_mesh(shape: str, sizes: dict[str, float], sag: float | None = None) -> Mesh:
    """Returns the mesh of a built-in shape; sizes [m] have the names of the scene file (`radius_m`, ...).

    sag: how far facets may be off the curves of a sphere or a cylinder [m], as a scattering model wants them; None: SAG.
    """
    plain = {key.removesuffix("_m"): value for key, value in sizes.items()}
    if sag is not None and shape == "sphere":
        return fine_sphere(plain["radius"], sag)
    if sag is not None and shape == "cylinder":
        return cylinder(**plain, sag=sag, max_sides=_MAX_FINE_SIDES)
    return SHAPES[shape](**plain)


def sphere(radius: float, sag: float = SAG) -> Mesh:
    """Returns an icosphere about the origin: facets within `sag` [m] of the sphere, at most 81 920 of them."""
    longest = 1.05 * 1.26 * radius  # edge of the icosahedron, and its unevenness after splitting
    splits = math.ceil(math.log2(longest / math.sqrt(6.0 * radius * sag)))  # a triangle of edge e sags by e^2 / (6 r)
    vertices, faces = _icosahedron()
    for _ in range(min(max(splits, 2), _MAX_SPLITS)):
        vertices, faces = _split(vertices, faces)
    return Mesh(radius * vertices, faces, solid=True)


def fine_sphere(radius: float, sag: float) -> Mesh:
    """Returns a sphere about the origin: facets within `sag` [m] of it, and no more of them than needed, at most 128,000."""
    parts = math.ceil(min(max(math.sqrt(_PARTS_SAG * radius / sag), _MIN_PARTS), _MAX_PARTS))
    vertices, faces = _divided(*_icosahedron(), parts)
    return Mesh(radius * vertices, faces, solid=True)


def _divided(vertices: Floats, faces: Indices, parts: int) -> tuple[Floats, Indices]:
    """Divides each edge into parts and each face into parts^2, with all vertices on the unit sphere."""
    index = {(i, j): number for number, (i, j) in enumerate((i, j) for i in range(parts + 1) for j in range(parts + 1 - i))}
    upright = [(index[i, j], index[i + 1, j], index[i, j + 1]) for i, j in index if i + j < parts]
    turned = [(index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]) for i, j in index if i + j < parts - 1]
    share = np.array([(parts - i - j, i, j) for i, j in index]) / parts
    points = (share @ vertices[faces]).reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    parted = np.array(upright + turned) + len(index) * np.arange(len(faces))[:, None, None]
    _, first, same = np.unique(np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return points[first], same.reshape(-1)[parted.reshape(-1, 3)]


def _icosahedron() -> tuple[Floats, Indices]:
    g = (1.0 + math.sqrt(5.0)) / 2.0
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
               (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]  # fmt: skip
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
             (8, 6, 7), (9, 8, 1)]  # fmt: skip
    return np.array(corners, dtype=np.float64) / math.hypot(1.0, g), np.array(faces, dtype=np.int64)


def _split(vertices: Floats, faces: Indices) -> tuple[Floats, Indices]:
    """Splits each face into four, with new vertices on the unit sphere."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, middle = np.unique(edges, axis=0, return_inverse=True)
    points = vertices[unique].sum(axis=1)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    ab, bc, ca = (middle.reshape(-1, 3) + len(vertices)).T
    a, b, c = faces.T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.concatenate([vertices, points]), np.concatenate([np.stack(part, axis=1) for part in parts])


def plate(width: float, height: float) -> Mesh:
    """Returns a vertical sheet about the origin with normal +y: width along x, height along z [m]."""
    w, h = width / 2.0, height / 2.0
    return _mesh([(w, 0, -h), (-w, 0, -h), (-w, 0, h), (w, 0, h)], [(0, 1, 2), (0, 2, 3)])


def box(length: float, width: float, height: float) -> Mesh:
    """Returns a closed box above the origin, length along y, width along x [m]."""
    x, y = width / 2.0, length / 2.0
    ring = [(-x, -y), (x, -y), (x, y), (-x, y)]
    return _prism(np.array(ring), height)


def cylinder(radius: float, height: float, sag: float = SAG, max_sides: int = _MAX_SIDES) -> Mesh:
    """Returns a closed vertical cylinder above the origin: sides within `sag` [m] of the curve, at most `max_sides`."""
    sides = 4 * math.ceil(min(max(2.0 * math.pi * math.sqrt(radius / (8.0 * sag)), 16.0), max_sides) / 4.0)
    turn = np.arange(sides) * (2.0 * np.pi / sides)
    return _prism(radius * np.stack([np.cos(turn), np.sin(turn)], axis=1), height)


def _prism(ring: Floats, height: float) -> Mesh:
    """Returns a vertical prism over a convex counter-clockwise ring (n, 2), with the middle of each end as a vertex."""
    n = len(ring)
    middle = ring.mean(axis=0)
    foot = np.column_stack([ring, np.zeros(n)])
    vertices = np.concatenate([foot, foot + (0, 0, height), [[*middle, 0.0], [*middle, height]]])
    i = np.arange(n)
    j = (i + 1) % n
    parts = [(i, j, j + n), (i, j + n, i + n), (j, i, np.full(n, 2 * n)), (i + n, j + n, np.full(n, 2 * n + 1))]
    return Mesh(vertices, np.concatenate([np.stack(part, axis=1) for part in parts]).astype(np.int64), solid=True)


def dihedral(width: float, height: float) -> Mesh:
    """Returns two vertical plates at a right angle, each width x height [m], open toward +y; the origin is in their fold."""
    s, h = width / math.sqrt(2.0), height / 2.0
    corners = [(0, 0, -h), (0, 0, h), (s, s, -h), (s, s, h), (-s, s, -h), (-s, s, h)]
    return _mesh(corners, [(2, 0, 1), (2, 1, 3), (0, 4, 5), (0, 5, 1)])


def trihedral(edge: float) -> Mesh:
    """Returns three perpendicular right triangles with legs `edge` [m], apex in the origin, axis of symmetry along +y."""
    y, up, side = 1.0 / math.sqrt(3.0), 1.0 / math.sqrt(6.0), 1.0 / math.sqrt(2.0)
    edges = [(0.0, y, 2.0 * up), (side, y, -up), (-side, y, -up)]  # right-handed: each normal is the third leg
    corners = [(0.0, 0.0, 0.0), *(tuple(edge * c for c in edge_end) for edge_end in edges)]
    return _mesh(corners, [(0, 1, 2), (0, 2, 3), (0, 3, 1)])


# Half breadth of deck and bottom, as shares of half the beam, along the ship from transom (-1) to bow (1), of a typical
# ship: a full stern, a parallel middle body, a flared bow with a raked stem.
_STATIONS = ((-1.0, 0.86, 0.70), (-0.8, 0.95, 0.84), (-0.5, 1.0, 0.92), (-0.45, 1.0, 0.93), (0.2, 1.0, 0.92),
             (0.45, 0.95, 0.80), (0.65, 0.80, 0.56), (0.80, 0.58, 0.32), (0.92, 0.30, 0.12), (1.0, 0.0, 0.0))  # fmt: skip
_HOUSE = (1, 2)  # the deckhouse stands between these stations
_HOUSE_BREADTH = 0.8  # of the beam
_DECK = 0.45  # height of the deck, of the whole height
_RAKE = 0.08  # the foot of the stem lies this share of half the length abaft the bow


def hull(length: float, beam: float, height: float) -> Mesh:
    """Returns a closed hull with a deckhouse aft: length along y (bow ahead), height from keel to house top [m]."""
    rings = []
    first, last = _HOUSE
    for k, (_, deck, _) in enumerate(_STATIONS):
        low, high = min(_HOUSE_BREADTH, deck), height
        if k == first:
            rings.append(_section(k, low, _DECK * height, length, beam, height))
        rings.append(_section(k, low, high if first <= k <= last else _DECK * height, length, beam, height))
        if k == last:
            rings.append(_section(k, low, _DECK * height, length, beam, height))
    return loft(np.array(rings))


def _section(k: int, house: float, top: float, length: float, beam: float, height: float) -> Floats:
    """Returns one ring (8, 3) of the hull: bottom, deck edge, foot and top of the house, starboard, then port."""
    along, deck, bottom = _STATIONS[k]
    y, foot = along * length / 2.0, ((along + 1.0) * (1.0 - _RAKE / 2.0) - 1.0) * length / 2.0
    b, d, h, z = bottom * beam / 2.0, deck * beam / 2.0, house * beam / 2.0, _DECK * height
    starboard = [(b, foot, 0.0), (d, y, z), (h, y, z), (h, y, top)]
    return np.array(starboard + [(-p[0], p[1], p[2]) for p in reversed(starboard)])


def loft(rings: Floats) -> Mesh:
    """Returns the closed surface over rings (s, n, 3) that are counter-clockwise seen from ahead, with caps at both ends."""
    s, n, _ = rings.shape
    k, i = np.meshgrid(np.arange(s - 1) * n, np.arange(n), indexing="ij")
    a, b = (k + i).ravel(), (k + (i + 1) % n).ravel()
    skin = np.concatenate([np.stack([a, b + n, b], axis=1), np.stack([a, a + n, b + n], axis=1)])
    fan = np.stack([np.zeros(n - 2, dtype=np.int64), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    bow = (s - 1) * n + fan[:, ::-1]
    return _merged(rings.reshape(-1, 3), np.concatenate([skin, fan, bow]))


def _merged(vertices: Floats, faces: Indices) -> Mesh:
    """Returns the closed mesh with equal vertices merged, without faces without area."""
    unique, index = np.unique(vertices + 0.0, axis=0, return_inverse=True)  # + 0.0: -0.0 and 0.0 are the same coordinate
    faces = index.reshape(-1)[faces]
    a, b, c = unique[faces].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Mesh(unique, faces[area > 0.0].astype(np.int64), solid=True)


def _mesh(vertices: Sequence[tuple[float, ...]], faces: list[tuple[int, int, int]]) -> Mesh:
    return Mesh(np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int64))


SHAPES: dict[str, Callable[..., Mesh]] = {
    "sphere": sphere,
    "plate": plate,
    "box": box,
    "cylinder": cylinder,
    "dihedral": dihedral,
    "trihedral": trihedral,
    "hull": hull,
}
