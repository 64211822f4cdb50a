"""Makes the terrain and the meshes of scenes/harbour.toml: `python -m tests.reference.make_scenes` writes them anew.

The harbour is nobody's: the shapes below were drawn for this project, and noise makes them rough. Only arithmetic that
every machine rounds alike is used (sums, products, quotients, roots), so that the files come out the same everywhere.
All places are east, north (, up) [m] from the scene's origin.
"""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Floats = NDArray[np.float64]
Positions = Sequence[tuple[float, float]]

FOLDER = Path(__file__).parents[2] / "scenes"
SEED = 1904  # of the noise: the year of Huelsmeyer's telemobiloscope
SIDE, EXTENT = 385, 12_288.0  # posts and metres a side: a post every 32 m
LOW, HIGH = -40.0, 280.0  # m, black and white of the height map

COAST: Positions = [(-6200, -500), (-5000, -900), (-4100, -1500), (-3500, -1250), (-3150, -300), (-2700, 500), (-1900, 950),
                 (-1150, 1150), (-700, 1650), (-300, 1800), (1900, 1800), (2150, 1250), (2700, 700), (3300, 950),
                 (3900, 450), (4700, 300), (5400, -400), (6200, -700)]  # fmt: skip
RIVER: Positions = [(1150, 1500), (1150, 2000), (900, 2600), (1350, 3300), (1000, 4100), (1500, 5000), (1300, 6200)]
RIVER_WIDTH: Positions = [(1500, 330), (1900, 230), (2600, 170), (4000, 110), (6200, 50)]  # north, half of the width
# middle east, north, half axes, height of the hill
ISLES = [
    ((2350, -2050), (780, 430), 75.0),
    ((3350, -2600), (300, 190), 30.0),
    ((-1650, -2700), (190, 120), 16.0),
    ((-1330, -2850), (90, 70), 8.0),
]
HILLS = [
    ((-3650, -350), (700, 900), 165.0),
    ((-1100, 3500), (1500, 900), 190.0),
    ((3300, 3000), (1400, 1100), 150.0),
    ((4800, 1500), (700, 600), 90.0),
    ((-4400, 3600), (1300, 1400), 120.0),
    ((200, 5600), (2500, 900), 160.0),
]

WEST_MOLE: Positions = [(-420, 1780), (-330, 1300), (-60, 1010), (330, 930)]
EAST_MOLE: Positions = [(2080, 1500), (1800, 1060), (1300, 880), (760, 850)]
# middle east, north, size east, north: tops 4 m above the sea
QUAYS = [(800, 1815, 2300, 90), (-60, 1640, 50, 300), (340, 1640, 60, 320), (700, 1660, 40, 260), (1640, 1560, 340, 480)]
SHEDS = [(-62, 1600, 24, 150, 9), (340, 1700, 36, 110, 12), (340, 1570, 36, 90, 10), (1700, 1600, 90, 60, 14),
         (1560, 1650, 60, 120, 12), (1600, 1420, 50, 70, 10)]  # fmt: skip
TANKS = [(1745, 1400, 18, 15), (1745, 1350, 18, 15), (1700, 1375, 14, 12), (1745, 1450, 18, 15)]  # radius, height
PONTOONS = [(80 + 40 * k, 1650, 4, 150) for k in range(4)]


def noise(x: Floats, y: Floats, cell: float, seed: int) -> Floats:
    """Smooth noise from -1 to 1: random values every `cell` [m], joined by smooth steps (Perlin's 3 t^2 - 2 t^3)."""
    count = int(2 * EXTENT / cell) + 3
    lattice = np.random.default_rng([SEED, seed]).random((count, count)) * 2.0 - 1.0
    u, v = (x + EXTENT) / cell, (y + EXTENT) / cell
    i, j = np.floor(u).astype(np.int64), np.floor(v).astype(np.int64)
    s, t = u - i, v - j
    s, t = s * s * (3.0 - 2.0 * s), t * t * (3.0 - 2.0 * t)
    south = lattice[i, j] * (1.0 - s) + lattice[i + 1, j] * s
    north = lattice[i, j + 1] * (1.0 - s) + lattice[i + 1, j + 1] * s
    return south * (1.0 - t) + north * t


def fractal(x: Floats, y: Floats, cell: float, octaves: int, seed: int) -> Floats:
    """Noise of `octaves` scales, each half as long and half as high as the one before."""
    total = np.zeros_like(x)
    for k in range(octaves):
        total += noise(x, y, cell / 2**k, seed + k) / 2**k
    return total


def mound(x: Floats, y: Floats, middle: tuple[float, float], axes: tuple[float, float]) -> Floats:
    """A bell 1 high in the middle and 1/4 at the half axes [m]."""
    u, v = (x - middle[0]) / axes[0], (y - middle[1]) / axes[1]
    flat = 1.0 + u * u + v * v
    bell: Floats = 1.0 / (flat * flat)
    return bell


def inland(x: Floats, y: Floats) -> Floats:
    """About how far inland [m] a place lies, negative at sea. The coast is rugged but for the harbour."""
    east, north = np.array(COAST, dtype=np.float64).T
    main: Floats = (y - np.interp(x, east, north)) * 0.75
    off = np.maximum(np.abs(x - 800.0) - 1200.0, np.abs(y - 1400.0) - 700.0)  # outside a rectangle about the harbour
    main = main + np.clip(off / 500.0, 0.0, 1.0) * 260.0 * fractal(x, y, 900.0, 6, 10)
    path, width = np.array(RIVER, dtype=np.float64), np.array(RIVER_WIDTH, dtype=np.float64)
    stream = np.abs(x - np.interp(y, path[:, 1], path[:, 0])) - np.interp(y, width[:, 0], width[:, 1])
    main = np.where(y > 1500, np.minimum(main, stream), main)
    for middle, axes, _ in ISLES:
        u, v = (x - middle[0]) / axes[0], (y - middle[1]) / axes[1]
        shore = (1.0 - np.sqrt(u * u + v * v)) * min(axes)
        main = np.maximum(main, shore + 0.22 * min(axes) * fractal(x, y, 400.0, 5, 30))
    return main


def heights(x: Floats, y: Floats) -> Floats:
    """Heights above the sea [m] of the ground, and of the sea bed, within LOW and HIGH."""
    depth_in = inland(x, y)
    rise = np.clip(depth_in / 900.0, 0.0, 1.0)
    hills = np.zeros_like(x)
    for middle, axes, height in HILLS + ISLES:
        hills += height * mound(x, y, middle, axes)
    rough = 1.0 + 0.45 * fractal(x, y, 700.0, 7, 50)
    shelf = np.clip(depth_in / 120.0, 0.0, 1.0)
    land = (
        np.clip(depth_in * 0.06, 0.0, 5.0) + shelf * hills * rough * 0.8 + rise * 25.0 * (1.0 + fractal(x, y, 1200.0, 6, 70))
    )
    return np.clip(np.where(depth_in > 0.0, np.maximum(land, 0.3), depth_in * 0.05 - 0.5), LOW, HIGH)


def terrain() -> NDArray[np.uint16]:
    """The height map (SIDE, SIDE), row 0 north: LOW is 0, HIGH is 65535."""
    along = np.linspace(-EXTENT / 2.0, EXTENT / 2.0, SIDE)
    x, y = np.broadcast_arrays(along[None, :], along[::-1, None])
    share = (heights(x.copy(), y.copy()) - LOW) / (HIGH - LOW)
    return np.rint(share * 65535.0).astype(np.uint16)


class Meshes:
    """Triangles gathered for one OBJ file, rounded to centimetres."""

    def __init__(self, title: str) -> None:
        self.lines = [f"# {title}", "# Made by tests/reference/make_scenes.py; metres, x east, y north, z up."]
        self.count = 0

    def add(self, vertices: Floats, faces: Sequence[Sequence[int]], name: str) -> None:
        """One object: vertices (V, 3) [m], faces as rows of indices from 0."""
        self.lines.append(f"o {name}")
        self.lines += [f"v {x:.2f} {y:.2f} {z:.2f}" for x, y, z in vertices + 0.0]
        self.lines += ["f " + " ".join(str(i + 1 + self.count) for i in face) for face in faces]
        self.count += len(vertices)

    def text(self) -> str:
        """The file."""
        return "\n".join(self.lines) + "\n"


def prism(ring: Floats, foot: float, top: float) -> tuple[Floats, list[list[int]]]:
    """Walls and roof over a counter-clockwise ring (n, 2) [m], open below."""
    n = len(ring)
    vertices = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in (foot, top)])
    sides = [[i, (i + 1) % n, (i + 1) % n + n] for i in range(n)] + [[i, (i + 1) % n + n, i + n] for i in range(n)]
    return vertices, sides + [[n, n + i, n + i + 1] for i in range(1, n - 1)]


def rectangle(east: float, north: float, across: float, along: float) -> Floats:
    """The corners (4, 2) of a rectangle about its middle, counter-clockwise."""
    return np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (across / 2.0, along / 2.0) + (east, north)


def gable(
    east: float, north: float, across: float, along: float, foot: float, eaves: float
) -> tuple[Floats, list[list[int]]]:
    """A house with its ridge to the north, open below; the roof rises by 0.35 of the width across."""
    walls = rectangle(east, north, across, along)
    ridge = [(east, north - along / 2.0, eaves + 0.35 * across), (east, north + along / 2.0, eaves + 0.35 * across)]
    vertices = np.concatenate([np.column_stack([walls, np.full(4, z)]) for z in (foot, eaves)] + [np.array(ridge)])
    sides = [[i, (i + 1) % 4, (i + 1) % 4 + 4] for i in range(4)] + [[i, (i + 1) % 4 + 4, i + 4] for i in range(4)]
    return vertices, [*sides, [4, 5, 8], [6, 7, 9], [5, 6, 9], [5, 9, 8], [7, 4, 8], [7, 8, 9]]


def polygon(east: float, north: float, radius: float) -> Floats:
    """Sixteen corners of a circle from halved angles: only roots, no table of sines."""
    corners = [np.array([1.0, 0.0]), np.array([0.0, 1.0])]
    for _ in range(2):
        between = [(a + b) / np.sqrt((a + b) @ (a + b)) for a, b in zip(corners, corners[1:], strict=False)]
        corners = [c for pair in zip(corners, [*between, corners[-1]], strict=True) for c in pair][:-1]
    quarter = np.array(corners[:-1])
    turns = [quarter, quarter[:, ::-1] * (-1, 1), -quarter, quarter[:, ::-1] * (1, -1)]
    return np.concatenate(turns) * radius + (east, north)


def mole(geometry: Positions, seed: int) -> tuple[Floats, list[list[int]]]:
    """A breakwater of armour stone along a polyline: crest 5 m above the sea, foot 2 m below, stones of half a metre."""
    stations = np.concatenate(
        [_steps(np.array(a, float), np.array(b, float)) for a, b in zip(geometry, geometry[1:], strict=False)]
    )
    ahead = np.gradient(stations, axis=0)
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / np.sqrt((ahead * ahead).sum(axis=1))[:, None]
    profile = [(13.0, -2.0), (10.0, 0.5), (7.0, 2.6), (3.5, 5.0), (-3.5, 5.0), (-7.0, 2.6), (-10.0, 0.5), (-13.0, -2.0)]
    jitter = np.random.default_rng([SEED, seed]).random((len(stations), len(profile), 3)) - 0.5
    rings = np.array([[(*(s + n * across), up) for across, up in profile] for s, n in zip(stations, left, strict=True)])
    vertices = (rings + jitter * (1.2, 1.2, 1.0)).reshape(-1, 3)
    n, k = len(profile), len(stations)
    quads = [(r * n + c, r * n + c + 1, (r + 1) * n + c + 1, (r + 1) * n + c) for r in range(k - 1) for c in range(n - 1)]
    faces = [[a, b, c] for a, b, c, _ in quads] + [[a, c, d] for a, _, c, d in quads]
    ends = [
        [base, base + i + turn, base + i + 1 - turn] for base, turn in ((0, 1), ((k - 1) * n, 0)) for i in range(1, n - 1)
    ]
    return vertices, faces + ends


def _steps(start: Floats, end: Floats) -> Floats:
    """Places every 8 m or less from start to just short of the end."""
    length = float(np.sqrt(((end - start) ** 2).sum()))
    return start + np.arange(0.0, 1.0, 1.0 / np.ceil(length / 8.0))[:, None] * (end - start)


def breakwaters() -> str:
    """Both moles."""
    meshes = Meshes("Two breakwaters of armour stone.")
    meshes.add(*mole(WEST_MOLE, 101), "west")
    meshes.add(*mole(EAST_MOLE, 102), "east")
    return meshes.text()


def quays() -> str:
    """Quays and piers, and the pontoons of a marina."""
    meshes = Meshes("Quays, piers and pontoons.")
    for k, (east, north, across, along) in enumerate(QUAYS):
        meshes.add(*prism(rectangle(east, north, across, along), -3.0, 4.0), f"quay{k}")
    for k, (east, north, across, along) in enumerate(PONTOONS):
        meshes.add(*prism(rectangle(east, north, across, along), -0.2, 0.6), f"pontoon{k}")
    return meshes.text()


def town() -> str:
    """Sheds and tanks on the quays, and houses of 7 to 14 m on the slopes behind, no two within 25 m of each other."""
    meshes = Meshes("Sheds, tanks and houses.")
    for k, (east, north, across, along, height) in enumerate(SHEDS):
        meshes.add(*gable(east, north, across, along, 4.0, 4.0 + height), f"shed{k}")
    for k, (east, north, radius, height) in enumerate(TANKS):
        meshes.add(*prism(polygon(east, north, radius), 4.0, 4.0 + height), f"tank{k}")
    for k, (east, north, across, along, ground, height) in enumerate(house_positions()):
        meshes.add(*gable(east, north, across, along, ground - 3.0, ground + height), f"house{k}")
    return meshes.text()


def house_positions() -> list[Floats]:
    """East, north, sizes, ground and eaves height [m] of the houses of the town: dense at the quay, thin on the hills."""
    u = np.random.default_rng([SEED, 200]).random((6000, 5)).T
    east, north = -1000.0 + 3400.0 * u[0], 1880.0 + 1500.0 * u[1] * u[1]
    ground = heights(east, north)
    drawn = np.column_stack([east, north, 7.0 + 7.0 * u[2], 9.0 + 12.0 * u[3], ground, 5.0 + 6.0 * u[4]])
    placed: list[Floats] = []
    for house in drawn[ground > 2.5]:
        if len(placed) < 420 and all(np.abs(house[:2] - other[:2]).max() > 25.0 for other in placed):
            placed.append(house)
    return placed


def files() -> dict[str, bytes]:
    """Every file this module makes, by name."""
    picture = io.BytesIO()
    Image.fromarray(terrain()).save(picture, "PNG", optimize=True)
    return {
        "harbour-terrain.png": picture.getvalue(),
        "harbour-breakwaters.obj": breakwaters().encode(),
        "harbour-quays.obj": quays().encode(),
        "harbour-town.obj": town().encode(),
    }


def main() -> None:
    """Write the files into `scenes/`."""
    for name, content in files().items():
        (FOLDER / name).write_bytes(content)
        print(f"{name}: {len(content)} bytes")


if __name__ == "__main__":
    main()
