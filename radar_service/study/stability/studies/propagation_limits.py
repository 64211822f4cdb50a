"""Propagation: range near zero, two-ray phase and nulls, a flat earth, the horizon, divergence and roughness."""

from collections.abc import Callable

import numpy as np

from radar_service.numerics import EARTH_RADIUS, Floats
from radar_service.propagation import ament, miller_brown, received_amplitude, specular_geometry, two_ray_factor
from radar_service.study.stability.finding import (
    WAVELENGTH,
    Axis,
    Expected,
    Finding,
    crossing,
    curve,
    decades,
    decibels,
    echo_amplitude,
    plain,
    scene_of,
)

EARTH = 4.0 / 3.0 * EARTH_RADIUS
ANTENNA, TARGET = 15.0, 10.0  # m above the sea


def range_to_zero(fine: int = 1) -> Finding:
    """Drives the range of a target to zero: received power against 1/R^4."""
    ranges = decades(1e-4, 1e3, 3)[::-1]
    radar = scene_of().radar
    excess = decibels((received_amplitude(radar, ranges) / echo_amplitude(radar, ranges, 1.0)) ** 2)
    return Finding(
        name="range near zero",
        method="received power as 1/R^4",
        setup="the radar equation from 1 km down to 0.1 mm",
        parameter=Axis("range [m]", log=True),
        values=plain(ranges),
        measured=Axis("power below 1/R^4 [dB]"),
        curves=(curve("the engine", -excess),),
        limit=0.1,
        limit_reason="a tenth of a decibel",
        boundary=crossing(ranges, -excess, 0.1, log=True),
        expected=Expected(1.0, 0.01, "range_min_m of the scene"),
        response="limited output",
        instead="constant power inside range_min_m",
        details="Inside range_min_m (1 m) the power stays constant. `check` states where the far field of the antenna begins; "
        "the service does not model its near field.",
    )


def two_ray_null(fine: int = 1) -> Finding:
    """Drives the distance: path difference of the reflected ray over a flat sea, by subtraction and by the engine."""
    ground = decades(100.0, 1e5, 8 * fine)
    d = ground.astype(np.longdouble)
    exact = np.hypot(d, np.longdouble(ANTENNA + TARGET)) - np.hypot(d, np.longdouble(ANTENNA - TARGET))
    double = np.hypot(ground, ANTENNA + TARGET) - np.hypot(ground, ANTENNA - TARGET)
    single = np.float32(1.0) * (
        np.hypot(ground.astype(np.float32), np.float32(ANTENNA + TARGET))
        - np.hypot(ground.astype(np.float32), np.float32(ANTENNA - TARGET))
    )
    engine = specular_geometry(ground, TARGET, ANTENNA).excess
    degrees = [
        np.maximum(np.asarray(np.abs(difference - exact) * (360.0 / WAVELENGTH), dtype=np.float64), 1e-16)
        for difference in (single, double, engine)
    ]
    return Finding(
        name="two-ray phase",
        method="path difference by subtraction in float32",
        setup="path difference of the ray reflected by a flat sea, antenna at 15 m, target at 10 m",
        parameter=Axis("distance [m]", log=True),
        values=plain(ground),
        measured=Axis("phase error [degrees]", log=True),
        curves=(
            curve("subtraction in float32", degrees[0]), curve("subtraction in float64", degrees[1]),
            curve("the engine", degrees[2]),
        ),
        limit=1.0,
        limit_reason="one degree",
        boundary=crossing(ground, degrees[0], 1.0, log=True),
        expected=Expected(2949.0, 0.02, "measured on this grid: 2^-12 m, a unit of 2^11 m, is 2.8 degrees"),
        response="another method",
        instead="a formula without the difference of two long paths",
        details="The engine computes the path difference without subtracting two long paths.",
    )  # fmt: skip


def null_depth(fine: int = 1) -> Finding:
    """Drives the distance from the farthest null over a flat sea: |F|^2."""
    middle = 2.0 * ANTENNA * TARGET / WAVELENGTH
    offsets = decades(1e-6, 1e3, 3)[::-1]
    factor = np.abs(two_ray_factor(middle + offsets, TARGET, ANTENNA, WAVELENGTH)) ** 2
    floor = np.abs(two_ray_factor(np.linspace(-20.0, 20.0, 4001) + middle, TARGET, ANTENNA, WAVELENGTH)).min() ** 2
    return Finding(
        name="two-ray null",
        method="a null of unlimited depth",
        setup="|F|^2 beside the null at 9417 m, horizontal polarization, smooth sea",
        parameter=Axis("distance from the null [m]", log=True),
        values=plain(offsets),
        measured=Axis("|F|^2 [dB]"),
        curves=(curve("the engine", decibels(factor)),),
        limit=float(decibels(floor)) + 1.0,
        limit_reason="one decibel above the bottom of the null",
        boundary=crossing(offsets, -decibels(factor / floor), -1.0, log=True),
        expected=Expected(0.66, 0.02, "measured"),
        response="physical limit",
        instead="the reflection coefficient of the sea, below 1",
        details="The sea reflects less than the whole wave, so the null has a bottom, and no logarithm or division sees zero.",
    )


def flat_earth(fine: int = 1) -> Finding:
    """Drives the distance: F^4 over a flat earth against F^4 over 4/3 earth."""
    ground = decades(500.0, 28_000.0, 12 * fine)
    flat, curved = two_ray_db(ground)
    difference = np.abs(flat - curved)
    return Finding(
        name="flat earth",
        method="a flat earth",
        setup="two-ray F^4 over a flat sea and over 4/3 earth, antenna at 15 m, target at 10 m",
        parameter=Axis("distance [m]", log=True),
        values=plain(ground),
        measured=Axis("F^4, difference [dB]"),
        curves=(curve("difference", difference), curve("flat", flat), curve("4/3 earth", curved)),
        limit=1.0,
        limit_reason="one decibel",
        boundary=crossing(ground, difference, 1.0, log=True),
        expected=Expected(690.0, 0.02, "measured on this grid"),
        response="another method",
        instead="4/3 earth, the default",
        details='4/3 earth is the default. A scene must set earth = "flat", and its plan then states a flat earth.',
    )


def two_ray_db(ground: Floats) -> tuple[Floats, Floats]:
    """Returns F^4 [dB] at distances [m] over a flat sea and over 4/3 earth."""
    radii = (np.inf, EARTH)
    flat, curved = (two_ray_factor(ground, TARGET, ANTENNA, WAVELENGTH, earth_radius=radius) for radius in radii)
    return decibels(np.abs(flat) ** 4), decibels(np.abs(curved) ** 4)


def horizon(fine: int = 1) -> Finding:
    """Drives the distance to the horizon: path difference in quarter wavelengths, and F^4."""
    ground = np.linspace(15_000.0, 30_000.0, 61)
    geometry = specular_geometry(ground, TARGET, ANTENNA, EARTH)
    quarters = np.where(geometry.grazing > 0, geometry.excess / (WAVELENGTH / 4.0), 0.0)
    factor = np.abs(two_ray_factor(ground, TARGET, ANTENNA, WAVELENGTH, earth_radius=EARTH)) ** 4
    return Finding(
        name="horizon",
        method="ray optics without diffraction",
        setup="path difference of the reflected ray before the horizon, antenna at 15 m, target at 10 m",
        parameter=Axis("distance [m]"),
        values=plain(ground),
        measured=Axis("quarter wavelengths, dB"),
        curves=(curve("path difference [quarter wavelengths]", quarters), curve("F^4 [dB]", decibels(factor, 1e-6))),
        limit=1.0,
        limit_reason="below a quarter wavelength diffraction dominates (Kerr 1951, ch. 2)",
        boundary=crossing(ground, 1.0 - quarters, 0.0),
        expected=Expected(16_770.0, 0.005, "a search of the shortest reflected path in extended precision"),
        response="documented",
        instead="ray optics up to the horizon, zero beyond; the plan states it",
        details="Beyond the horizon F is 0. The service has no diffraction, so echoes close before the horizon are too strong; "
        "the plan states it.",
    )


def divergence_edge(fine: int = 1) -> Finding:
    """Drives the distance: grazing angle against the smallest valid one, and the divergence factor."""
    ground = np.linspace(2_000.0, 28_900.0, 55)
    geometry = specular_geometry(ground, TARGET, ANTENNA, EARTH)
    ratio = min_grazing(WAVELENGTH, EARTH) / geometry.grazing
    return Finding(
        name="divergence",
        method="the geometric divergence factor",
        setup="reflection by a curved sea, antenna at 15 m, target at 10 m",
        parameter=Axis("distance [m]"),
        values=plain(ground),
        measured=Axis("ratio [1]"),
        curves=(
            curve("smallest valid angle / grazing angle", np.minimum(ratio, 10.0)),
            curve("divergence factor D", geometry.divergence),
        ),
        limit=1.0,
        limit_reason="the factor is not valid at grazing angles below (lambda / (2 pi ae))^(1/3) (Kerr 1951, ch. 5)",
        boundary=crossing(ground, ratio, 1.0),
        expected=Expected(18_052.0, 0.005, "the angle by hand, 0.842 mrad; the distance is measured"),
        response="documented",
        instead="the same factor up to the horizon; the plan states that diffraction is missing",
        details="D falls to 0 before the horizon. F therefore goes to 1 and then, beyond the horizon, to 0.",
    )  # fmt: skip


def min_grazing(wavelength: float, earth_radius: float) -> float:
    """Returns the smallest valid grazing angle [rad] of divergence, (lambda / (2 pi ae))^(1/3): 0.84 mrad at 9.41 GHz."""
    return float((wavelength / (2.0 * np.pi * earth_radius)) ** (1.0 / 3.0))


def roughness(fine: int = 1) -> Finding:
    """Drives the Rayleigh parameter: the specular laws of Ament and of Miller and Brown."""
    g = decades(0.01, 100.0, 8 * fine)
    wave_height = g * WAVELENGTH / (4.0 * np.pi * np.sin(0.01))
    exponential, bessel = (_specular(law, wave_height) for law in (ament, miller_brown))
    difference = 20.0 * np.log10(bessel / np.maximum(exponential, 1e-300))
    return Finding(
        name="rough sea",
        method="Ament's law, as printed",
        setup="coherent reflection by a rough sea: Ament (printed) and Miller-Brown (the engine)",
        parameter=Axis("g = 4 pi rms height sin(grazing) / lambda [1]", log=True),
        values=plain(g),
        measured=Axis("reflection, difference [dB]"),
        curves=(
            curve("Miller-Brown over Ament", np.minimum(difference, 60.0)), curve("Miller-Brown", 20.0 * np.log10(bessel)),
        ),
        limit=3.0,
        limit_reason="Ament's law is 3 dB below Miller-Brown",
        boundary=crossing(g, difference, 3.0, log=True),
        expected=Expected(1.5625, 0.04, "I0(g^2 / 2) = 10^(3/20); the grid has 8 steps to a decade"),
        response="another method",
        instead="Miller-Brown at every g",
        details="The engine uses Miller-Brown at every g. `documented` keeps Ament as printed. Both are finite for every sea.",
    )  # fmt: skip


def _specular(law: Callable[[float, float, float], Floats], wave_heights: Floats) -> Floats:
    return np.array([float(law(0.01, height, WAVELENGTH)) for height in wave_heights])


STUDIES = (range_to_zero, two_ray_null, null_depth, flat_earth, horizon, divergence_edge, roughness)
