"""Texture of land: trees, hedges and houses, which stand on the ground and are finer than a height map.

Billingsley, Low-Angle Radar Land Clutter (2002), p. 295, rural land of low relief: mean sigma0 does not vanish at low angles;
beyond 4 degrees, without shadows, the power of cells has a Weibull law of aw = 2.6. Powers are drawn for the cell at time 0.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import gamma as gamma_function
from scipy.special import kv

from radar_service.numerics.types import Floats
from radar_service.scattering.surface_sampling import Scatterers
from radar_service.world.body import Body

AREAS = 1e3, 1e6  # m2
CELL = 1.6  # independent area of a cell over beamwidth x c / 2B: of a Gaussian beam, two ways, 1.06, of a weighted chirp 1.5
STEEPEST = 0.5  # upward part of a normal: parts stand on the ground, and not on the walls at the edge of a map


class Terrain(NamedTuple):
    """What stands on land. grazing: its mean sigma0 at grazing angles; spread: aw of cells of AREAS; height: of its parts [m]."""

    grazing: float
    spread: tuple[float, float]
    height: float


# The spread of the larger cells is recalled. Height: ITU-R P.452, nominal clutter heights: parkland, orchards, sparse houses.
RURAL = Terrain(10.0**-3.3, (2.6, 1.5), 4.0)
_TERRAIN = {"vegetation": RURAL, "land": RURAL}


def terrain_of(body: Body) -> Terrain | None:
    """Returns what stands on a body; None unless it is a height map of measured material."""
    return _TERRAIN.get(body.material.name) if body.one_sided else None


def rms_slope(terrain: Terrain, gamma: float) -> float:
    """Returns the rms slope [rad] of parts: gamma max(slope, 0) has the mean gamma slope / sqrt(2 pi)."""
    return float(np.sqrt(2.0 * np.pi) * terrain.grazing / gamma)


def texture_shape(spread: float) -> float:
    """Returns the shape nu of a K law with the median (ln 2)^aw / gamma(1 + aw) of a Weibull law; spread: aw above 1.

    K: 2 / gamma(nu) z^nu K_nu(2 z), z^2 = nu x (Ward, Tough and Watts 2006).
    """
    median = np.log(2.0) ** spread / gamma_function(1.0 + spread)

    def excess(shape: float) -> float:
        root = np.sqrt(shape * median)
        return float(2.0 / gamma_function(shape) * root**shape * kv(shape, 2.0 * root) - 0.5)

    return float(brentq(excess, 1e-2, 1e2))


def with_texture(points: Scatterers, terrain: Terrain, gamma: float, cell: Floats, rng: np.random.Generator) -> Scatterers:
    """Returns scatterers (E,) of random slope, height and power; cell: (E,) area of the cell of each [m^2]."""
    ground = points.normal[:, 2] > STEEPEST
    shapes = [texture_shape(spread) for spread in terrain.spread]
    shape = np.exp(np.interp(np.log(cell), np.log(AREAS), np.log(shapes))) * points.area / (CELL * cell)
    power = np.where(ground, rng.standard_gamma(shape) / shape, 1.0)
    slope = ground[:, None] * rms_slope(terrain, gamma) * rng.standard_normal((len(points), 3))
    lift = ground * terrain.height * rng.random(len(points))
    position = points.position + lift[:, None] * [0.0, 0.0, 1.0]
    phasor, middle = points.phasor * np.sqrt(power), points.middle + lift
    return Scatterers(position, points.normal + slope, points.area, points.triangle, phasor, middle, points.span)
