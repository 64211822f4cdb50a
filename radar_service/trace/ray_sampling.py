"""Rays from the antenna: the documented sampler, and full circles of rays with solid angles.

The documented sampler draws rays in a box of 1.5 beamwidths each side of boresight, anew for each azimuth, and counts each
alike. A full circle has the same density of rays, drawn once for all azimuths. Its hits pass the beam like any echo, and each
ray has its share of the sphere.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radar_service.numerics import Floats

BOX_BEAMWIDTHS = 1.5  # beamwidths each side of boresight, docs/specification.md eqs. 4, 5
MAX_RAYS = 8_000_000  # in a full circle: some 2 GB of memory


def azimuth_offsets(generator: np.random.Generator, count: int, beamwidth: float) -> Floats:
    """Offsets (count,) of the rays from boresight in azimuth [rad], uniform in +-1.5 beamwidths. Source:
    docs/specification.md eq. 4."""
    return generator.uniform(-BOX_BEAMWIDTHS * beamwidth, BOX_BEAMWIDTHS * beamwidth, count)  # eq. 4


def elevation_offsets(generator: np.random.Generator, count: int, beamwidth_el: float) -> Floats:
    """Offsets (count,) of the rays from the horizontal [rad], uniform in +-1.5 beamwidths. Source:
    docs/specification.md eq. 5."""
    return generator.uniform(-BOX_BEAMWIDTHS * beamwidth_el, BOX_BEAMWIDTHS * beamwidth_el, count)  # eq. 5


@dataclass(frozen=True)
class Rays:
    """Rays (M,) over a whole turn: azimuth and elevation [rad], and the solid angle [sr] that each stands for."""

    azimuth: Floats
    elevation: Floats
    solid_angle: Floats

    def __post_init__(self) -> None:
        assert self.azimuth.shape == self.elevation.shape == self.solid_angle.shape

    def __len__(self) -> int:
        return len(self.azimuth)


def uniform_square(generator: np.random.Generator, across: int, up: int) -> Floats:
    """Independent points (across x up, 2) of the unit square: the law of docs/specification.md eqs. 4 and 5."""
    return generator.random((across * up, 2))


def stratified_square(generator: np.random.Generator, across: int, up: int) -> Floats:
    """One point at random in each of `across` x `up` equal cells of the unit square (jittered sampling; Cook 1986)."""
    cell = np.stack(np.meshgrid(np.arange(across), np.arange(up), indexing="ij"), axis=-1).reshape(-1, 2)
    return np.asarray((cell + generator.random(cell.shape)) / (across, up))


def sobol_square(generator: np.random.Generator, across: int, up: int) -> Floats:
    """A scrambled Sobol' net of at least `across` x `up` points, a power of two (Sobol' 1967; Owen 1995)."""
    bits = max(0, int(np.ceil(np.log2(across * up))))
    from scipy.stats import qmc  # here: it would take a sixth of every start

    return np.asarray(qmc.Sobol(2, scramble=True, seed=generator).random_base2(bits), dtype=np.float64)


SAMPLERS: dict[str, Callable[[np.random.Generator, int, int], Floats]] = {
    "rays": uniform_square,
    "stratified": stratified_square,
    "sobol": sobol_square,
}


def full_circle_rays(
    sampler: str, generator: np.random.Generator, per_box: int, beamwidth: float, beamwidth_el: float, tilt: float
) -> Rays:
    """Rays over the full circle, within 1.5 beamwidths above and below the tilt, about `per_box` to 3 x 3 beamwidths.

    beamwidth, beamwidth_el, tilt: [rad]. Raises KeyError for an unknown sampler. Each sampler is uniform in
    azimuth and elevation in the mean, and a ray stands for cos(elevation) times an equal share of the angles. Raises ValueError
    for more than MAX_RAYS rays.
    """
    low = max(-np.pi / 2.0, tilt - BOX_BEAMWIDTHS * beamwidth_el)
    high = min(np.pi / 2.0, tilt + BOX_BEAMWIDTHS * beamwidth_el)
    up = max(1, round(np.sqrt(per_box)))
    across = max(1, round(per_box / up * 2.0 * np.pi / (2.0 * BOX_BEAMWIDTHS * beamwidth)))
    if across * up > MAX_RAYS:
        box = f"a box of 3 x {np.rad2deg(beamwidth):g} degrees"
        raise ValueError(
            f"radar.rays: {per_box} to {box} are {across * up} in a full circle; at most {MAX_RAYS}: lower rays"
        )
    square = SAMPLERS[sampler](generator, across, up)
    azimuth = 2.0 * np.pi * square[:, 0]
    elevation = low + (high - low) * square[:, 1]
    return Rays(azimuth, elevation, np.cos(elevation) * (2.0 * np.pi * (high - low) / len(square)))


def missed_area_range(rays: int, beamwidth: float, beamwidth_el: float) -> float:
    """Range [m] beyond which uniform rays miss a square metre at boresight with a probability of 5 % or more.

    rays: to a box of 3 x 3 beamwidths [rad]. (1 - p)^N = 0.05, p the square metre's share of the box.
    """
    share = -math.expm1(math.log(0.05) / rays)
    return 1.0 / math.sqrt(share * (2.0 * BOX_BEAMWIDTHS) ** 2 * beamwidth * beamwidth_el)
