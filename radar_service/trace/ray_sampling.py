"""Rays from the antenna: the documented sampler, and whole turns of rays that carry the solid angle they stand for.

The documented one throws rays at random into a box of 1.5 beamwidths each side of boresight, for each azimuth anew, and
counts each alike. A whole turn is thrown by the same law, as many rays to a box, but once for all azimuths, so that what
they meet passes under the beam as anything else does; each ray carries its share of the sphere.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
REACH = 1.5  # beamwidths each side of boresight, docs/specification.md eqs. 4, 5
MOST = 8_000_000  # rays in a turn: some 2 GB while they are thrown


def azimuth_offsets(generator: np.random.Generator, count: int, beamwidth: float) -> Floats:
    """Offsets (count,) of the rays from boresight in azimuth [rad], uniform in +-1.5 beamwidths. Source:
    docs/specification.md eq. 4."""
    return generator.uniform(-REACH * beamwidth, REACH * beamwidth, count)  # eq. 4


def elevation_offsets(generator: np.random.Generator, count: int, beamwidth_el: float) -> Floats:
    """Offsets (count,) of the rays from the horizontal [rad], uniform in +-1.5 beamwidths. Source:
    docs/specification.md eq. 5."""
    return generator.uniform(-REACH * beamwidth_el, REACH * beamwidth_el, count)  # eq. 5


def printed_direction(azimuth: Floats, elevation: Floats) -> Floats:
    """Unit vectors (M, 3) exactly as printed: the azimuth [rad] counts from x counter-clockwise. Source:
    docs/specification.md eq. 6.

    With eqs. 21 and 22, which count from y clockwise, it mirrors the picture about the line of 45 degrees
    (docs/specification.md, errata row 8); so the documented chain itself sends its rays along `frames.direction`.
    """
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)  # eq. 6


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


def rays_round(
    sampler: str, generator: np.random.Generator, per_box: int, beamwidth: float, beamwidth_el: float, tilt: float
) -> Rays:
    """Rays over the whole turn, within 1.5 beamwidths above and below the tilt, about `per_box` to 3 x 3 beamwidths.

    beamwidth, beamwidth_el, tilt: [rad]. Raises KeyError for an unknown sampler. Whatever law the places follow, uniform in
    azimuth and elevation in the mean, a ray stands for cos(elevation) x the angles shared out evenly, so a sum over
    rays estimates the integral over the box without bias. Raises ValueError for more than MOST rays.
    """
    low = max(-np.pi / 2.0, tilt - REACH * beamwidth_el)
    high = min(np.pi / 2.0, tilt + REACH * beamwidth_el)
    up = max(1, round(np.sqrt(per_box)))
    across = max(1, round(per_box / up * 2.0 * np.pi / (2.0 * REACH * beamwidth)))
    if across * up > MOST:
        box = f"a box of 3 x {np.rad2deg(beamwidth):g} degrees"
        raise ValueError(f"radar.rays: {per_box} to {box} are {across * up} in a turn; at most {MOST}: lower rays")
    square = SAMPLERS[sampler](generator, across, up)
    azimuth = 2.0 * np.pi * square[:, 0]
    elevation = low + (high - low) * square[:, 1]
    return Rays(azimuth, elevation, np.cos(elevation) * (2.0 * np.pi * (high - low) / len(square)))


def missed_area_range(rays: int, beamwidth: float, beamwidth_el: float) -> float:
    """Range [m] beyond which uniform rays miss a square metre at boresight with a probability of 5 % or more.

    rays: to a box of 3 x 3 beamwidths [rad]. (1 - p)^N = 0.05, p the square metre's share of the box.
    """
    share = -math.expm1(math.log(0.05) / rays)
    return 1.0 / math.sqrt(share * (2.0 * REACH) ** 2 * beamwidth * beamwidth_el)
