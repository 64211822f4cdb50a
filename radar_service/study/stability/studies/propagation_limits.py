"""Propagation: range near zero, two-ray phase, a flat earth, and the horizon."""

import numpy as np

from radar_service.numerics.constants import EARTH_RADIUS
from radar_service.numerics.types import Floats
from radar_service.propagation.multipath import specular_geometry, two_ray_factor
from radar_service.propagation.radar_equation import received_amplitude
from radar_service.study.stability.closed_form import WAVELENGTH, echo_amplitude, scene_of
from radar_service.study.stability.finding import Axis, Expected, Finding, crossing, curve, decades, decibels, plain

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
        instead="ray optics up to the horizon and zero beyond, which the plan states, or `diffraction`",
        details="Without `diffraction` F is 0 beyond the horizon, and echoes close before it are too strong; the plan states it.",
    )


STUDIES = (range_to_zero, two_ray_null, flat_earth, horizon)
