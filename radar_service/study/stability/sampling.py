"""Where sampling fails: rays that miss a target, and plain sums over too few points of a facet."""

import numpy as np

from radar_service.frames import direction
from radar_service.random import RAYS, generator
from radar_service.scattering.physical_optics.facet_integral import triangle_phases
from radar_service.study.stability.finding import Axis, Finding, crossing, curve, decades, decibels, places
from radar_service.trace.embree import TriangleScene
from radar_service.trace.line_of_sight import Floats
from radar_service.trace.ray_sampling import REACH, azimuth_offsets, elevation_offsets

WAVENUMBER = 2.0 * np.pi * 9.41e9 / 299_792_458.0
BEAM, BEAM_EL, RAYS_AN_AZIMUTH = np.deg2rad(3.9), np.deg2rad(25.0), 2000  # of the default radar
AWAY = 1000.0  # m to the plates of different size
TILT = np.deg2rad(10.0)  # at which the plate is seen


def missed_targets(fine: int = 1) -> Finding:
    """A plate of 1 m^2, square on, under the documented rays: how many azimuths meet it not once."""
    ranges = decades(20.0, 5000.0, 3)
    measured = [_missed_share(r, 1.0, 200 * fine, k) for k, r in enumerate(ranges)]
    law = missed_by_law(ranges, np.ones(len(ranges)))
    return Finding(
        "uniform sampling", "2000 uniform rays in 3 x 3 beamwidths of 3.9 x 25 degrees, a plate of 1 m x 1 m",
        Axis("range [m]", log=True), places(ranges), Axis("share of azimuths that miss it [1]"),
        (curve("measured", measured), curve("binomial law", law)), 0.05, "one azimuth in twenty without an echo",
        crossing(ranges, law, 0.05, log=True), "says so",
        "Only documented and the ray samplers throw rays; plan says from where on a square metre is missed. "
        "balanced puts scatterers on the surface itself and misses nothing.",
    )  # fmt: skip


def missed_sizes(fine: int = 1) -> Finding:
    """Square plates of ever smaller size a kilometre away, under the same rays."""
    sides = decades(0.1, 100.0, 3)[::-1]
    measured = [_missed_share(AWAY, side, 200 * fine, 100 + k) for k, side in enumerate(sides)]
    law = missed_by_law(np.full(len(sides), AWAY), sides)
    return Finding(
        "uniform sampling against size", "the same rays, square plates of different size 1 km away",
        Axis("side of the plate [m]", log=True), places(sides), Axis("share of azimuths that miss it [1]"),
        (curve("measured", measured), curve("binomial law", law)), 0.05, "one azimuth in twenty without an echo",
        crossing(sides, law, 0.05, log=True), "says so",
        "As above: a ship's side of 20 m is as far as 2000 rays to an azimuth reach at 1 km.",
    )  # fmt: skip


def missed_by_law(distance: Floats, side: Floats) -> Floats:
    """(1 - p)^N, p the share of the box that a square of `side` [m] fills at `distance` [m]."""
    half = np.arctan(0.5 * side / distance)
    return np.asarray((1.0 - (2.0 * half) ** 2 / (2.0 * REACH * BEAM * 2.0 * REACH * BEAM_EL)) ** RAYS_AN_AZIMUTH)


def _missed_share(distance: float, side: float, azimuths: int, key: int) -> float:
    """Share of azimuths, all on the plate's own bearing, whose rays all miss it."""
    x, y = side / 2.0, distance
    plate = TriangleScene(
        np.array([[-x, y, -x], [x, y, -x], [x, y, x], [-x, y, x]]), np.array([[0, 1, 2], [0, 2, 3]])
    )  # fmt: skip
    rng = generator(0, RAYS, key)
    count = azimuths * RAYS_AN_AZIMUTH
    ray = direction(azimuth_offsets(rng, count, BEAM), elevation_offsets(rng, count, BEAM_EL))
    hit = plate.first_hit(np.zeros(3), ray).reshape(azimuths, -1) >= 0
    return float((~hit.any(axis=1)).mean())


def undersampled_facet(fine: int = 1) -> Finding:
    """A plate of 1 m seen 10 degrees off its normal: points in a grid, summed with their phases, and the closed form."""
    density = np.array([0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 16.0])
    phase = 2.0 * WAVENUMBER * np.sin(TILT)
    exact = float(np.sinc(phase / (2.0 * np.pi)))
    sums = []
    for per_wavelength in density:
        count = max(1, round(per_wavelength * WAVENUMBER / (2.0 * np.pi)))
        sums.append(abs(np.exp(1j * phase * ((np.arange(count) + 0.5) / count - 0.5)).mean() / exact) ** 2)
    x = 0.5
    corners = np.array([[[-x, 0, -x], [x, 0, -x], [x, 0, x]], [[-x, 0, -x], [x, 0, x], [-x, 0, x]]])
    centre = corners.mean(axis=1)
    gradient = np.broadcast_to(np.array([2.0 * np.sin(TILT), 0.0, 0.0]), (2, 3))
    whole = triangle_phases(corners, centre, gradient, WAVENUMBER) * np.exp(-1j * WAVENUMBER * (gradient * centre).sum(1))
    engine = abs(whole.mean() / exact) ** 2
    error = np.abs(decibels(np.array(sums)))
    return Finding(
        "under-sampled facets", "a plain coherent sum over a grid of points, and the engine's facets in closed form",
        Axis("points to a wavelength [1]", log=True), places(density), Axis("error of the power [dB]", log=True),
        (curve("plain sum", np.maximum(error, 1e-6)),
         curve("the engine", np.full(len(density), max(float(np.abs(decibels(engine))), 1e-12)))),
        0.5, "half a decibel, a metre's plate 10 degrees off its normal",
        crossing(density[::-1], error[::-1], 0.5, log=True), "computes right",
        "The engine integrates every facet in closed form; no density is chosen.",
    )  # fmt: skip
