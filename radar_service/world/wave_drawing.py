"""Draws the waves of a seaway from a spectrum: apart from its records, because random numbers take long to import."""

import numpy as np

from radar_service.numerics import GRAVITY, SEAWAY, Floats, generator
from radar_service.world.seaway import Seaway, Waves
from radar_service.world.stream import NO_STREAM, Stream

WAVES = 64  # regular waves; their bands are 2.9 % wide, a third of the resonance of a roll with 5 % of critical damping
LOWEST, HIGHEST = 0.55, 3.5  # frequencies over that of the peak: 1.2e-6 of the energy lies below, 0.8 % above
DIRECTIONS = 4001  # points of the table of directions: its steps are 0.045 degrees


def drawn_waves(seaway: Seaway, stream: Stream = NO_STREAM) -> Waves:
    """Returns the waves of a seaway. The variance of their sum over time is (height / 4)^2.

    A wave has the energy of its band of the spectrum, a frequency within the band, and a direction. Directions are spread
    evenly over their distribution, in random order. stream: of the water, east and north [m/s].
    """
    rng = generator(seaway.seed, SEAWAY)
    peak = 2.0 * np.pi / seaway.period
    edges = peak * np.geomspace(LOWEST, HIGHEST, WAVES + 1)
    energy = np.diff(energy_below(edges, peak))
    frequency = edges[:-1] * (edges[1:] / edges[:-1]) ** rng.random(WAVES)
    share = (np.argsort(rng.random(WAVES)) + rng.random(WAVES)) / WAVES
    direction = seaway.towards + _directions(share, seaway.spread)
    wavenumber = (frequency**2 / GRAVITY)[:, None] * np.stack([np.sin(direction), np.cos(direction)], axis=1)
    return Waves(
        amplitude=seaway.height / 4.0 * np.sqrt(2.0 * energy / energy.sum()),
        frequency=frequency,
        wavenumber=wavenumber,
        over_ground=frequency + wavenumber @ np.array(stream),
        phase=2.0 * np.pi * rng.random(WAVES),
    )


def energy_below(frequency: Floats, peak: float) -> Floats:
    """Returns the share (...) of a wave spectrum's energy below frequencies (...) [rad/s]; peak: of the spectrum [rad/s].

    S(w) = 5/16 H^2 wp^4 w^-5 exp(-5/4 (wp / w)^4), whose integral is H^2 / 16 exp(-5/4 (wp / w)^4): Bretschneider 1959, the
    two-parameter spectrum of the ITTC 1978; of a fully developed sea it is that of Pierson and Moskowitz 1964.
    """
    return np.asarray(np.exp(-1.25 * (peak / frequency) ** 4))


def _directions(share: Floats, spread: float) -> Floats:
    """Directions (N,) off the mean one [rad] below which these shares (N,) of the energy go."""
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, DIRECTIONS)
    density = np.cos(angle) ** (2.0 * spread)
    below = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    return np.interp(share, below / below[-1], angle)
