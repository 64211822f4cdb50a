"""Where propagation fails: range towards zero, the two-ray null, the horizon, a flat earth, divergence, roughness."""

import numpy as np

from radar_service.propagation.multipath import specular_geometry, two_ray_factor
from radar_service.propagation.radar_equation import received_amplitude
from radar_service.propagation.sea_surface import ament, miller_brown
from radar_service.study.stability.finding import Axis, Finding, crossing, curve, decades, decibels, places
from radar_service.study.stability.twin import level, scene_of
from radar_service.trace.line_of_sight import Floats

WAVELENGTH = 299_792_458.0 / 9.41e9
EARTH = 4.0 / 3.0 * 6_371_000.0
ANTENNA, TARGET = 15.0, 10.0  # m above the sea


def range_to_zero(fine: int = 1) -> Finding:
    """Received power against 1/R^4 as the target comes to the antenna."""
    ranges = decades(1e-4, 1e3, 3)[::-1]
    radar = scene_of().radar
    excess = decibels((received_amplitude(radar, ranges) / level(radar, ranges, 1.0)) ** 2)
    return Finding(
        "range towards zero", "the radar equation down to 0.1 mm",
        Axis("range [m]", log=True), places(ranges), Axis("power short of 1/R^4 [dB]"),
        (curve("the engine", -excess),), 0.1, "a tenth of a decibel",
        crossing(ranges, -excess, 0.1, log=True), "falls back",
        "Inside range_min_m (1 m) the power stays as it is there. check says where the antenna's far field begins; "
        "nearer its pattern is not formed, which is not modelled.",
    )  # fmt: skip


def two_ray_null(fine: int = 1) -> Finding:
    """Path difference of the reflected ray over a flat sea: plain subtraction, single precision, the engine's form."""
    ground = decades(100.0, 1e5, 8 * fine)
    d = ground.astype(np.longdouble)
    exact = np.hypot(d, np.longdouble(ANTENNA + TARGET)) - np.hypot(d, np.longdouble(ANTENNA - TARGET))
    plain = np.hypot(ground, ANTENNA + TARGET) - np.hypot(ground, ANTENNA - TARGET)
    single = np.float32(1.0) * (
        np.hypot(ground.astype(np.float32), np.float32(ANTENNA + TARGET))
        - np.hypot(ground.astype(np.float32), np.float32(ANTENNA - TARGET))
    )
    ours = specular_geometry(ground, TARGET, ANTENNA).excess
    turns = [
        np.maximum(np.asarray(np.abs(geometry - exact) * (360.0 / WAVELENGTH), dtype=np.float64), 1e-16)
        for geometry in (single, plain, ours)
    ]
    return Finding(
        "two-ray phase", "path difference of the sea-reflected ray, antenna 15 m, target 10 m, flat sea",
        Axis("distance [m]", log=True), places(ground), Axis("phase error [degrees]", log=True),
        (curve("subtracted, single precision", turns[0]), curve("subtracted, double precision", turns[1]),
         curve("the engine", turns[2])),
        1.0, "a degree", crossing(ground, turns[0], 1.0, log=True), "computes right",
        "The difference is computed without subtracting kilometres from kilometres.",
    )  # fmt: skip


def null_depth(fine: int = 1) -> Finding:
    """|F|^2 through the farthest null over a flat sea, in finer and finer steps."""
    middle = 2.0 * ANTENNA * TARGET / WAVELENGTH
    offsets = decades(1e-6, 1e3, 3)[::-1]
    factor = np.abs(two_ray_factor(middle + offsets, TARGET, ANTENNA, WAVELENGTH)) ** 2
    floor = np.abs(two_ray_factor(np.linspace(-20.0, 20.0, 4001) + middle, TARGET, ANTENNA, WAVELENGTH)).min() ** 2
    over = decibels(factor / floor)
    return Finding(
        "two-ray null", "|F|^2 beside the null at 9417 m, horizontal polarization, smooth sea",
        Axis("distance from the null [m]", log=True), places(offsets), Axis("|F|^2 [dB]"),
        (curve("the engine", decibels(factor)),), float(decibels(floor)) + 1.0,
        "within a decibel of the bottom, which the sea's own loss sets",
        crossing(offsets, -over, -1.0, log=True), "computes right",
        "The sea reflects less than all, so the null has a bottom and no logarithm or division meets zero.",
    )  # fmt: skip


def flat_earth(fine: int = 1) -> Finding:
    """F^4 over a flat earth beside F^4 over 4/3 earth: worst within 5 % of each distance, so nulls count as nulls."""
    ground = decades(500.0, 28_000.0, 12 * fine)
    flat, curved = two_ray_db(ground)
    apart = np.abs(flat - curved)
    return Finding(
        "flat earth", "two-ray F^4 over a flat sea against one curved as 4/3 earth, antenna 15 m, target 10 m",
        Axis("distance [m]", log=True), places(ground), Axis("[dB]"),
        (curve("difference", apart), curve("flat", flat), curve("4/3 earth", curved)), 1.0, "a decibel",
        crossing(ground, apart, 1.0, log=True), "says so",
        '4/3 earth is the default; earth = "flat" must be asked for, and plan says that it was.',
    )  # fmt: skip


def two_ray_db(ground: Floats) -> tuple[Floats, Floats]:
    """F^4 [dB] at distances [m] over a flat sea and over one curved as 4/3 earth."""
    radii = (np.inf, EARTH)
    flat, curved = (two_ray_factor(ground, TARGET, ANTENNA, WAVELENGTH, earth_radius=radius) for radius in radii)
    return decibels(np.abs(flat) ** 4), decibels(np.abs(curved) ** 4)


def horizon(fine: int = 1) -> Finding:
    """The last kilometres before the horizon: path difference in quarter wavelengths, and F^4."""
    ground = np.linspace(15_000.0, 30_000.0, 61)
    geometry = specular_geometry(ground, TARGET, ANTENNA, EARTH)
    quarters = np.where(geometry.grazing > 0, geometry.excess / (WAVELENGTH / 4.0), 0.0)
    factor = np.abs(two_ray_factor(ground, TARGET, ANTENNA, WAVELENGTH, earth_radius=EARTH)) ** 4
    return Finding(
        "near the horizon", "ray optics where the path difference falls below a quarter wavelength (Kerr 1951, ch. 2)",
        Axis("distance [m]"), places(ground), Axis("quarter wavelengths; dB"),
        (curve("path difference [quarter wavelengths]", quarters), curve("F^4 [dB]", decibels(factor, 1e-6))), 1.0,
        "below a quarter wavelength diffraction, which is not modelled, takes over",
        crossing(ground, 1.0 - quarters, 0.0), "says so",
        "Beyond the horizon F is 0. plan says that nothing diffracts: too strong close before it.",
    )  # fmt: skip


def divergence_edge(fine: int = 1) -> Finding:
    """Grazing angle and divergence against the angle below which a curved sea has no single point of reflection."""
    ground = np.linspace(2_000.0, 28_900.0, 55)
    geometry = specular_geometry(ground, TARGET, ANTENNA, EARTH)
    least = least_grazing(WAVELENGTH, EARTH)
    share = least / geometry.grazing
    return Finding(
        "divergence", "the geometric divergence factor towards grazing, antenna 15 m, target 10 m",
        Axis("distance [m]"), places(ground), Axis("[1]"),
        (curve("least angle / grazing angle", np.minimum(share, 10.0)), curve("divergence factor D", geometry.divergence)), 1.0,
        "grazing below (lambda / (2 pi ae))^(1/3), where the factor is no longer valid (Kerr 1951, ch. 5)",
        crossing(ground, share, 1.0), "says so", "As for the horizon: D falls to 0 there, so F goes to 1 and then to 0.",
    )  # fmt: skip


def least_grazing(wavelength: float, earth_radius: float) -> float:
    """Grazing angle [rad] below which geometric divergence fails: (lambda / (2 pi ae))^(1/3), 0.84 mrad at 9.41 GHz."""
    return float((wavelength / (2.0 * np.pi * earth_radius)) ** (1.0 / 3.0))


def roughness(fine: int = 1) -> Finding:
    """The two laws of specular roughness, Ament's and Miller and Brown's, against the Rayleigh parameter."""
    g = decades(0.01, 100.0, 8 * fine)
    wave = g * WAVELENGTH / (4.0 * np.pi * np.sin(0.01))
    exact, wide = (_specular(law, wave) for law in (ament, miller_brown))
    apart = 20.0 * np.log10(wide / np.maximum(exact, 1e-300))
    return Finding(
        "roughness", "what a rough sea still mirrors: Ament (printed) and Miller-Brown (the engine)",
        Axis("g = 4 pi rms height sin(grazing) / lambda [1]", log=True), places(g), Axis("[dB]"),
        (curve("Miller-Brown over Ament", np.minimum(apart, 60.0)), curve("Miller-Brown", 20.0 * np.log10(wide))), 3.0,
        "Ament's law gives 3 dB too little", crossing(g, apart, 3.0, log=True), "computes right",
        "The engine uses Miller-Brown at every g; documented keeps Ament as printed. Both stay finite for any sea.",
    )  # fmt: skip


def _specular(law: object, wave: Floats) -> Floats:
    assert callable(law)
    return np.array([float(law(0.01, height, WAVELENGTH)) for height in wave])
