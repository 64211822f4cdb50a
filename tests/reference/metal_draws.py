"""Random draws of metal on the water, and what the oracle says of them: the published distributions of the acceptance tests.

Lengths and ranges are drawn evenly in their logarithm, angles and heights evenly. One lobe is lambda / 2W, W the width.

| what | distribution |
|---|---|
| kind | plate (half of them lean by up to 10 degrees), mast (0.1 to 0.5 m square, 3 to 8 m), box, flare (up to 25 degrees) |
| sizes | 0.3 to 8 m; near field: plates and boxes of 2 to 8 m |
| range | 100 to 4000 m; near field: 60 to 400 m; turning: 100 to 2000 m, passing: 60 to 300 m |
| aspect | within 3 lobes of a face's normal (60 %; 75 % in shadow, near and turning; near: within 2.5 degrees), else anywhere |
| aspect in shadow | at most 80 degrees off the normal: beyond, 0.1 mm of the wall moves the shadow by a millimetre |
| lowest point | the water (30 %), else up to 6 m above it; waterline: 5 to 95 % of the height lies below it |
| antenna | 5 to 40 m; either polarization; vertical beam 15 to 30 degrees; sea state 0 to 5; earth 4/3 (80 %) or flat |
| sea reflects | always in rows 1 and 2; in 60 % of the others |
| hidden | 0 to 95 % of a plate, by a tall wall from one side or a low one from below, at 30 to 95 % of the range |
| turning | 0.5 to 6 degrees/s either way, a quarter of them due north; 30 % pass at 5 to 40 knots instead |
| spokes | rows 2 and 6: all within the half-power beam, 720 a scan, 24 rpm, 3.9 degrees, 5 MHz: a body fills one range cell |
| points | 0.5 to 25 m high, 5 to 40 knots, half of them straight in or out, within 5 antenna heights to 4000 m, up to 60 s late |
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from tests.reference import metal_on_water as oracle
from tests.reference.compressed_pulse import compressed_pulse, in_bins, sinc2_beam
from tests.reference.metal_on_water import EARTH, Face, Floats, Screen, Setting

KNOT = 1852.0 / 3600.0  # m/s
NEIGHBOURS = 16
STEEPEST = np.deg2rad(80.0)  # off the normal of a plate in shadow
PERIOD, BEAMWIDTH = 2.5, np.deg2rad(3.9)  # of the default radar: s per scan, and rad
BANDWIDTH, PULSE, HAMMING = 5e6, 10e-6, (0.54, 0.46)
CELL = oracle.LIGHT / (2.0 * BANDWIDTH)  # m: every body lies within one range cell, so that a spoke holds one amplitude
POWER, GAIN = 25e3, 1e3  # W, and power ratio
BINS_PER_CELL = 30


@dataclass(frozen=True)
class Wall:
    """An opaque wall at a share `along` of the range that hides a share `hidden` of a plate, from one side or from below."""

    along: float
    hidden: float
    tall: bool
    side: float


@dataclass(frozen=True)
class Draw:
    """One body and what looks at it.

    row, number: of the table, and of the draw; kind: what it is; faces: in the body's own frame; none: a point.
    distance, bearing, up: of the body's origin at `time`; heading: then [rad].
    width, height: extents [m]; velocity: (3,) [m/s]; turn: [rad/s]; wall: in front of it; scan: that is compared.
    """

    row: int
    number: int
    kind: str
    setting: Setting
    faces: tuple[Face, ...]
    distance: float
    bearing: float
    up: float
    heading: float
    width: float
    height: float
    wall: Wall | None = None
    velocity: Floats = field(default_factory=lambda: np.zeros(3))
    turn: float = 0.0
    scan: int = 0

    @property
    def time(self) -> float:
        """When the beam crosses the body [s], at which position and heading are given."""
        return (self.scan + self.bearing / (2.0 * np.pi)) * PERIOD

    @property
    def lobe(self) -> float:
        """Lobe of the width [rad], half a turn at most."""
        return min(self.setting.wavelength / (2.0 * self.width), np.pi / 2)

    def position(self, time: float) -> Floats:
        """Position (3,) at a time [m]."""
        middle = np.array([self.distance * np.sin(self.bearing), self.distance * np.cos(self.bearing), self.up])
        return np.asarray(middle + self.velocity * (time - self.time))

    def placed(self, time: float) -> list[Face]:
        """Faces on the map at a time."""
        heading = self.heading + self.turn * (time - self.time)
        return [oracle.placed(face, self.position(time), heading) for face in self.faces]

    @property
    def screens(self) -> list[Screen]:
        """The wall, square to the bearing."""
        if self.wall is None:
            return []
        ahead, right = (
            np.array([np.sin(self.bearing), np.cos(self.bearing)]),
            np.array([np.cos(self.bearing), -np.sin(self.bearing)]),
        )
        foot, wall = self.wall.along * self.distance, self.wall
        if wall.tall:
            apparent = self.width * abs(np.cos(self.heading - self.bearing))
            edge = wall.along * wall.side * apparent * (wall.hidden - 0.5)
            side = -wall.side * 100.0 * right
            corner = foot * ahead + edge * right
            return [Screen(np.array([*corner, -5.0]), np.array([*side, 0.0]), np.array([0.0, 0.0, 105.0]))]
        radius, antenna = self.setting.earth_radius, self.setting.antenna_height
        split = self.up - self.height / 2 + wall.hidden * self.height - self.distance**2 / (2 * radius)
        top = antenna + (split - antenna) * wall.along + foot**2 / (2 * radius)
        corner = foot * ahead - 50.0 * right
        return [
            Screen(np.array([*corner, -5.0]), np.array([*(100.0 * right), 0.0]), np.array([0.0, 0.0, 5.0 + max(top, 0.1)]))
        ]

    def moved(self, farther: float, turned: float) -> "Draw":
        """The same body at another range, and turned [rad]."""
        return replace(self, distance=self.distance * farther, heading=self.heading + turned)

    @property
    def slant(self) -> float:
        """Slant range of the origin [m] when the beam crosses it."""
        return oracle.slant_range(self.position(self.time), self.setting)

    def __str__(self) -> str:
        s = self.setting
        parts = [
            f"row {self.row} #{self.number} {self.kind} {self.width:.2f} x {self.height:.2f} m at {self.distance:.0f} m",
            f"bearing {np.rad2deg(self.bearing):.1f} heading {np.rad2deg(self.heading) % 360:.2f} up {self.up:.2f}",
            f"antenna {s.antenna_height:.1f} {s.polarization} sea {s.sea_state if s.sea else 'none'}",
            "flat" if np.isinf(s.earth_radius) else "4/3",
        ]
        if self.wall is not None:
            where = "tall" if self.wall.tall else "low"
            parts.append(f"{where} wall at {self.wall.along:.2f} hides {self.wall.hidden:.0%}")
        if self.turn:
            parts.append(f"turns {np.rad2deg(self.turn):.2f} deg/s")
        if self.velocity.any():
            parts.append(f"moves ({self.velocity[0]:.1f}, {self.velocity[1]:.1f}) m/s")
        return ", ".join(parts) + f", scan {self.scan}"


# ------------------------------------------------------------------------------------------------------------------ the oracle


def amplitude(draw: Draw, size: float | None = None) -> float:
    """The oracle's |b| [m] at the instant at which the beam crosses the body; size: of brute-force elements [m]."""
    if not draw.faces:
        return float(abs(oracle.two_ray_field(draw.position(draw.time)[None], draw.setting)[0]) ** 2)
    return abs(oracle.scattering_amplitude(draw.placed(draw.time), draw.setting, draw.slant, draw.screens, size))


def local_rms(draw: Draw, count: int = NEIGHBOURS) -> float:
    """The oracle's rms [m] over 5 % of range and one lobe of aspect both ways, at points of a rank-1 lattice."""
    share = (np.outer(np.arange(count) + 0.5, [0.7548776662466927, 0.5698402909980532]) % 1.0) * 2.0 - 1.0  # Roberts' R2
    levels = [amplitude(draw.moved(1.0 + 0.05 * u, draw.lobe * v)) for u, v in share]
    return float(np.sqrt(np.mean(np.square(levels))))


def spoke_field(draw: Draw, ranges: Floats, boresight: Floats, time: Floats) -> np.ndarray:
    """The oracle's field (K, N) [sqrt(W)] at samples `ranges` (N,) [m] of spokes at boresights (K,) [rad] and times (K,) [s]."""
    setting, rows = draw.setting, []
    moves = bool(draw.turn or draw.velocity.any())
    parts: list[oracle.Contributions] = []
    for angle, instant in zip(boresight, time, strict=True):
        if moves or not rows:
            parts = contributions(draw, instant)
        rows.append(compressed(parts, ranges, angle))
    level = np.sqrt(POWER * GAIN**2 * setting.wavelength**2 / (4.0 * np.pi) ** 3)
    return np.asarray(level * np.array(rows))


def contributions(draw: Draw, time: float) -> list[oracle.Contributions]:
    """What a draw returns at a time [s]."""
    if draw.faces:
        return oracle.pieces(draw.placed(time), draw.setting, draw.screens, None)
    return [point_contributions(draw.position(time)[None], draw.setting)]


def point_contributions(position: Floats, setting: Setting) -> oracle.Contributions:
    """What points (M, 3) of 1 m^2 return: F^2 at the direct range, as declared cross-sections are defined. (Where the ways by
    the sea are longer by a range cell, a body of metal has echoes of their own behind the direct one; a point has not.)"""
    direct = oracle.direct_rays(position, setting)
    weight = (direct.weight * oracle.two_ray_field(position, setting)) ** 2
    return oracle.Contributions(weight[None], direct.length[None], np.arctan2(position[:, 0], position[:, 1]))


def compressed(
    parts: list[oracle.Contributions], ranges: Floats, boresight: float, beamwidth: float = BEAMWIDTH,
    bandwidth: float = BANDWIDTH,
) -> np.ndarray:  # fmt: skip
    """Compressed profile (N,) of contributions at a boresight: sorted into short bins, each of which is one pulse."""
    if not parts:
        return np.zeros(len(ranges), dtype=np.complex128)
    bin_length = oracle.LIGHT / (2.0 * bandwidth) / BINS_PER_CELL
    lengths = np.concatenate([part.length.ravel() for part in parts])
    beam = [sinc2_beam(boresight - part.azimuth, beamwidth) for part in parts]
    amplitudes = np.concatenate([(part.amplitude * gain).ravel() for part, gain in zip(parts, beam, strict=True)])
    total = in_bins((lengths - lengths.min()) / bin_length, amplitudes)
    filled = np.flatnonzero(total)
    delay = 2.0 * (ranges[:, None] - (lengths.min() + bin_length * filled)) / oracle.LIGHT
    return np.asarray(compressed_pulse(delay, bandwidth, PULSE, HAMMING) @ total[filled])


def unit_energy(draw: Draw, ranges: Floats, boresight: Floats) -> Floats:
    """Root of the energy (K,) of a spoke that holds 1 m^2 at the body's place in free space."""
    free = replace(draw.setting, sea=False, beamwidth_el=None)
    point = replace(draw, faces=(), setting=free, velocity=np.zeros(3))
    field_ = spoke_field(point, ranges, boresight, np.full(len(boresight), draw.time))
    return np.asarray(np.linalg.norm(field_, axis=1))


# ------------------------------------------------------------------------------------------------------------------- the draws


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between two, even in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def any_setting(rng: np.random.Generator, sea: float) -> Setting:
    """Radar and sea; sea: the share that reflects."""
    return Setting(
        antenna_height=rng.uniform(5.0, 40.0),
        polarization=str(rng.choice(["h", "v"])),
        beamwidth_el=np.deg2rad(rng.uniform(15.0, 30.0)),
        sea=bool(rng.random() < sea),
        sea_state=int(rng.integers(0, 6)),
        earth_radius=EARTH if rng.random() < 0.8 else np.inf,
    )


@dataclass(frozen=True)
class Shape:
    """Faces about the origin; lowest: z of its lowest point; normal, width: of the faces drawn for the aspect."""

    kind: str
    faces: tuple[Face, ...]
    width: float
    height: float
    lowest: float
    normals: tuple[tuple[float, float], ...]  # bearing in the body's frame from +y to starboard [rad], width of the face [m]


def any_shape(rng: np.random.Generator, kinds: tuple[str, ...], low: float = 0.3, high: float = 8.0) -> Shape:
    """A body of one of the kinds."""
    kind = str(rng.choice(kinds))
    if kind == "plate":
        width, height = log_uniform(rng, low, high), log_uniform(rng, low, high)
        lean = float(rng.choice([0.0, rng.uniform(-1, 1) * np.deg2rad(10.0)]))
        return flat_plate(width, height, lean)
    if kind == "mast":
        side = log_uniform(rng, 0.1, 0.5)
        return prism(kind, (side, side), (side, side), log_uniform(rng, 3.0, 8.0))
    x, y, height = log_uniform(rng, low, high), log_uniform(rng, low, high), log_uniform(rng, low, high)
    wider = 2.0 * height * np.tan(np.deg2rad(rng.uniform(0.0, 25.0))) if kind == "flare" else 0.0
    return prism(kind, (x, y), (x + wider, y + wider), height)


def flat_plate(width: float, height: float, lean: float = 0.0) -> Shape:
    """A sheet."""
    tall = height * np.cos(lean)
    return Shape("plate", tuple(oracle.plate(width, height, lean)), width, tall, -tall / 2, ((0.0, width), (np.pi, width)))


def prism(kind: str, bottom: tuple[float, float], top: tuple[float, float], height: float) -> Shape:
    """A closed body."""
    normals = tuple((quarter * np.pi / 2, top[quarter % 2]) for quarter in range(4))
    return Shape(kind, tuple(oracle.prism(bottom, top, height)), max(top), height, 0.0, normals)


def any_aspect(rng: np.random.Generator, shape: Shape, near: float, within: float | None = None) -> float:
    """Bearing of the radar in the body's frame [rad]: with probability `near` within 3 lobes of a face's normal, or `within`
    [rad], else anywhere."""
    normal, width = shape.normals[rng.integers(len(shape.normals))]
    if rng.random() >= near:
        return float(rng.uniform(0.0, 2.0 * np.pi))
    return float(normal + rng.uniform(-1, 1) * (within or 3.0 * Setting().wavelength / (2.0 * width)))


def metal(row: int, number: int, rng: np.random.Generator, setting: Setting, shape: Shape, distance: float, aspect: float,
          bottom: float, bearing: float | None = None) -> Draw:  # fmt: skip
    """A body whose lowest point is at a height `bottom`."""
    where = rng.uniform(0.0, 2.0 * np.pi) if bearing is None else bearing
    heading = where + np.pi - aspect
    return Draw(row, number, shape.kind, setting, shape.faces, distance, where, bottom - shape.lowest, heading, shape.width,
                shape.height)  # fmt: skip


def over_the_sea(number: int, rng: np.random.Generator) -> Draw:
    """Row 1: metal meshes with multipath."""
    shape = any_shape(rng, ("plate", "mast", "box", "flare"))
    bottom = 0.0 if rng.random() < 0.3 else rng.uniform(0.0, 6.0)
    return metal(
        1, number, rng, any_setting(rng, 1.0), shape, log_uniform(rng, 100.0, 4000.0), any_aspect(rng, shape, 0.6), bottom
    )


def moving_point(number: int, rng: np.random.Generator) -> Draw:
    """Row 2: points under way over the sea."""
    setting = any_setting(rng, 1.0)
    distance = log_uniform(rng, 5.0 * setting.antenna_height, 4000.0)
    bearing = rng.uniform(0.0, 2.0 * np.pi)
    course = bearing + rng.choice([0.0, np.pi]) if rng.random() < 0.5 else rng.uniform(0.0, 2.0 * np.pi)
    velocity = rng.uniform(5.0, 40.0) * KNOT * np.array([np.sin(course), np.cos(course), 0.0])
    up, scan = rng.uniform(0.5, 25.0), int(rng.integers(0, 24))
    return Draw(2, number, "point", setting, (), distance, bearing, up, 0.0, 0.01, 0.0, velocity=velocity, scan=scan)


def shadowed(number: int, rng: np.random.Generator) -> Draw:
    """Row 3: plates partly hidden."""
    shape = flat_plate(log_uniform(rng, 0.3, 8.0), log_uniform(rng, 0.3, 8.0))
    setting, distance, aspect = any_setting(rng, 0.6), log_uniform(rng, 100.0, 4000.0), any_aspect(rng, shape, 0.75)
    while abs(np.cos(aspect - shape.normals[0][0])) < np.cos(STEEPEST):
        aspect = any_aspect(rng, shape, 0.0)
    draw = metal(3, number, rng, setting, shape, distance, aspect, rng.uniform(0.0, 6.0))
    wall = Wall(rng.uniform(0.3, 0.95), rng.uniform(0.0, 0.95), bool(rng.random() < 0.5), float(rng.choice([-1.0, 1.0])))
    return replace(draw, wall=wall)


def in_the_water(number: int, rng: np.random.Generator) -> Draw:
    """Row 4: bodies partly below the water."""
    shape = any_shape(rng, ("plate", "mast", "box", "flare"))
    bottom = -rng.uniform(0.05, 0.95) * shape.height
    return metal(
        4, number, rng, any_setting(rng, 0.6), shape, log_uniform(rng, 100.0, 4000.0), any_aspect(rng, shape, 0.6), bottom
    )


def near_by(number: int, rng: np.random.Generator) -> Draw:
    """Row 5: large plates and boxes near by."""
    shape = any_shape(rng, ("plate", "plate", "box"), 2.0, 8.0)
    aspect = any_aspect(rng, shape, 0.75, np.deg2rad(2.5))
    return metal(5, number, rng, any_setting(rng, 0.6), shape, log_uniform(rng, 60.0, 400.0), aspect, rng.uniform(0.0, 3.0))


def turning(number: int, rng: np.random.Generator) -> Draw:
    """Row 6: plates that turn, and plates that are passed. The sea is smooth: clutter would hide them."""
    shape = any_shape(rng, ("plate",))
    setting = replace(any_setting(rng, 0.6), sea_state=0)
    passing = rng.random() < 0.3
    distance = log_uniform(rng, 60.0, 300.0) if passing else log_uniform(rng, 100.0, 2000.0)
    north = rng.uniform(-0.5, 0.5) * BEAMWIDTH % (2.0 * np.pi)
    bearing = north if rng.random() < 0.25 else rng.uniform(0.0, 2.0 * np.pi)
    draw = metal(6, number, rng, setting, shape, distance, any_aspect(rng, shape, 0.75), rng.uniform(0.0, 4.0), bearing)
    scan = int(rng.integers(0, 3))
    if passing:
        course = rng.uniform(0.0, 2.0 * np.pi)
        speed = rng.uniform(5.0, 40.0) * KNOT
        return replace(draw, velocity=speed * np.array([np.sin(course), np.cos(course), 0.0]), scan=scan)
    return replace(draw, turn=float(rng.choice([-1, 1])) * np.deg2rad(log_uniform(rng, 0.5, 6.0)), scan=scan)


ROWS: dict[int, Callable[[int, np.random.Generator], Draw]] = {
    1: over_the_sea, 2: moving_point, 3: shadowed, 4: in_the_water, 5: near_by, 6: turning,
}  # fmt: skip


def drawn(row: int, number: int, seed: int) -> Draw:
    """One draw of a row."""
    return ROWS[row](number, np.random.default_rng([seed, row, number]))
