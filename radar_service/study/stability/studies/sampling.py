"""Sampling: rays that miss a target, and coherent sums over too few points of a facet."""

from typing import Any

import numpy as np

from radar_service.numerics import RAYS, Floats, direction, generator
from radar_service.scattering import BodyLeg, Longest, PlanarPieces, PlaneOptics, Wave
from radar_service.study.stability.finding import (
    WAVELENGTH,
    Axis,
    Expected,
    Finding,
    crossing,
    curve,
    decades,
    decibels,
    plain,
)
from radar_service.trace import BOX_BEAMWIDTHS, TriangleScene, azimuth_offsets, elevation_offsets
from radar_service.world import MAP_POSE, Mesh

WAVENUMBER = 2.0 * np.pi / WAVELENGTH
BEAM, BEAM_EL, RAYS_PER_AZIMUTH = np.deg2rad(3.9), np.deg2rad(25.0), 2000  # of the default radar
DISTANCE = 1000.0  # m to the plates of different size
TILT = np.deg2rad(10.0)  # from the normal of the plate to the antenna


def missed_targets(fine: int = 1) -> Finding:
    """Drives the range of a plate of 1 m^2, square on: share of azimuths whose documented rays all miss it."""
    ranges = decades(20.0, 5000.0, 3)
    return _missed(
        "range", Axis("range [m]", log=True), ranges, (ranges, np.ones(len(ranges))), 200 * fine, 0,
        setup="rays in 3 x 3 beamwidths of 3.9 x 25 degrees at a plate of 1 m x 1 m",
        expected=Expected(
            46.4, 0.05, "(1 - p)^2000 = 0.05: p = 1.5e-3, R^2 = 1 / (p x 0.2042 x 1.3090): 49.9 m; interpolation -7 %"
        ),
        details="Only `documented` and the ray samplers use rays; their plan states the range from which they miss a square "
        "metre. `balanced` puts scatterers on the surface and misses no target.",
    )  # fmt: skip


def missed_sizes(fine: int = 1) -> Finding:
    """Drives the size of square plates at 1 km: share of azimuths whose documented rays all miss it."""
    sides = decades(0.1, 100.0, 3)[::-1]
    return _missed(
        "size", Axis("side of the plate [m]", log=True), sides, (np.full(len(sides), DISTANCE), sides), 200 * fine, 100,
        setup="the same rays at square plates of different size, 1 km away",
        expected=Expected(
            20.0, 0.05, "(1 - p)^2000 = 0.05 at 1 km: side = 1000 m x sqrt(p x 0.2673 sr); interpolation as over range"
        ),
        details="2000 rays for each azimuth are enough for a ship's side of 20 m at 1 km.",
    )  # fmt: skip


def _missed(
    over: str, axis: Axis, values: Floats, plates: tuple[Floats, Floats], azimuths: int, first_key: int, **fields: Any
) -> Finding:
    """The share of azimuths whose rays all miss a plate. plates: their distances and sides, each of the shape of values [m]."""
    measured = [_missed_share(*plate, azimuths, first_key + k) for k, plate in enumerate(zip(*plates, strict=True))]
    law = missed_by_law(*plates)
    return Finding(
        name=f"uniform rays over {over}",
        method="2000 uniform rays for each azimuth",
        parameter=axis,
        values=plain(values),
        measured=Axis("share of azimuths without a hit [1]"),
        curves=(curve("measured", measured), curve("binomial law", law)),
        limit=0.05,
        limit_reason="one azimuth in twenty has no echo",
        boundary=crossing(values, law, 0.05, log=True),
        response="another method",
        instead="scatterers on the surface (`balanced`)",
        **fields,
    )


def missed_by_law(distance: Floats, side: Floats) -> Floats:
    """Returns (1 - p)^N, where p is the share of the box of rays that a square of `side` [m] fills at `distance` [m]."""
    half = np.arctan(0.5 * side / distance)
    return np.asarray(
        (1.0 - (2.0 * half) ** 2 / (2.0 * BOX_BEAMWIDTHS * BEAM * 2.0 * BOX_BEAMWIDTHS * BEAM_EL)) ** RAYS_PER_AZIMUTH
    )


def _missed_share(distance: float, side: float, azimuths: int, key: int) -> float:
    """Returns the share of azimuths on the plate's bearing whose rays all miss it."""
    x, y = side / 2.0, distance
    plate = TriangleScene(
        np.array([[-x, y, -x], [x, y, -x], [x, y, x], [-x, y, x]]), np.array([[0, 1, 2], [0, 2, 3]])
    )  # fmt: skip
    rng = generator(0, RAYS, key)
    count = azimuths * RAYS_PER_AZIMUTH
    ray = direction(azimuth_offsets(rng, count, BEAM), elevation_offsets(rng, count, BEAM_EL))
    hit = plate.first_hit(np.zeros(3), ray).reshape(azimuths, -1) >= 0
    return float((~hit.any(axis=1)).mean())


def undersampled_facet(fine: int = 1) -> Finding:
    """Drives the density of points on a plate of 1 m, 10 degrees off its normal: their coherent sum."""
    density = np.array([0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 16.0])
    phase = 2.0 * WAVENUMBER * np.sin(TILT)
    exact = float(np.sinc(phase / (2.0 * np.pi)))
    sums = []
    for per_wavelength in density:
        count = max(1, round(per_wavelength * WAVENUMBER / (2.0 * np.pi)))
        sums.append(abs(np.exp(1j * phase * ((np.arange(count) + 0.5) / count - 0.5)).mean() / exact) ** 2)
    error = np.abs(decibels(np.array(sums)))
    engine = max(float(np.abs(decibels(_facet_power(exact)))), 1e-12)
    return Finding(
        name="under-sampled facets",
        method="coherent sum over a grid of points",
        setup="a plate of 1 m, 10 degrees off its normal, against its closed form",
        parameter=Axis("points for each wavelength [1]", log=True),
        values=plain(density),
        measured=Axis("error of the power [dB]", log=True),
        curves=(curve("sum over points", np.maximum(error, 1e-6)), curve("the engine", np.full(len(density), engine))),
        limit=0.5,
        limit_reason="half a decibel",
        boundary=crossing(density[::-1], error[::-1], 0.5, log=True),
        expected=Expected(1.9, 0.03, "measured; at 2 points for each wavelength (63 points) 0.43 dB, at 1 point 1.8 dB"),
        response="another method",
        instead="the integral of each facet in closed form",
        details="The engine integrates every facet in closed form, so there is no density to choose.",
    )


def _facet_power(exact: float) -> float:
    """Returns the power of the plate by the engine over the exact power."""
    x, distance = 0.5, 1e6
    mesh = Mesh(np.array([[-x, 0, -x], [x, 0, -x], [x, 0, x], [-x, 0, x]]), np.array([[0, 1, 2], [0, 2, 3]]))
    plate = PlaneOptics(PlanarPieces.of(mesh, np.zeros(2, dtype=np.int8)), Wave(WAVELENGTH, "h"), 1, 0.0)
    antenna = distance * np.array([np.sin(TILT), -np.cos(TILT), 0.0])
    echoes = plate.echoes((BodyLeg(False, MAP_POSE, antenna, np.inf),), -np.inf, Longest(x))
    field = 2.0 * np.sqrt(np.pi) / WAVELENGTH * np.cos(TILT) * exact
    return float(abs(echoes.amplitude.sum() / field) ** 2)


STUDIES = (missed_targets, missed_sizes, undersampled_facet)
