"""Own ship's structures near the antenna: what a mast or a funnel takes from the beam, by diffraction in closed form.

A structure is an upright opaque cylinder of radius a at distance d, which stands as a black strip of width 2 a across the way of
the waves (Kirchhoff; Babinet). An antenna of length D is far inside its near field there: D^2 / lambda is 230 m for 2.7 m in X
band. So each element of the aperture has the Fresnel integrals of the strip's edges of its own, and the pattern is their sum over
the aperture. Source: Born and Wolf, Principles of Optics, 1999, 8.7.3; ITU-R P.526-15, 4.1 (knife edge) and 5.2 (screens).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Complexes, Floats
from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.patterns import line_source

MAX_ASIDE = np.radians(80.0)  # from a structure's bearing; beyond, nothing of it stands before the aperture
TAPER_BEGIN, TAPER_END = 6.0, 8.0  # Fresnel units beyond the last edge, over which ripples of 0.4 dB at most are faded out


@dataclass(frozen=True)
class Structure:
    """A mast, a funnel or a post near the antenna.

    name: of the structure.
    bearing: of its middle from the antenna, clockwise from the bow [rad].
    distance: from the middle of the antenna to its middle [m].
    radius: half of its width [m].
    top: height of its top over the middle of the antenna [m]; inf: far above the beam. It reaches far below.
    reflection: of the field at its side, 0 to 1; 0: it makes no indirect echoes.
    """

    name: str
    bearing: float
    distance: float
    radius: float
    top: float = np.inf
    reflection: float = 1.0


class Aperture(NamedTuple):
    """An aperture of a length [m], lit at x by the sum of weights (N,) times exp(-2 pi j positions (N,) x / length)."""

    length: float
    positions: tuple[float, ...]
    weights: tuple[float, ...]

    def pattern(self, cycles: Floats) -> Floats:
        """The field far off (any shape), 1 on boresight; cycles: of the phase along the aperture, D sin(offset) / lambda."""
        field = np.zeros(np.shape(cycles))
        for position, weight in zip(self.positions, self.weights, strict=True):
            field += weight * np.sinc(cycles - position)
        return field

    def illumination(self, along: Floats) -> Floats:
        """The field at places (N,) from its middle [m], with an average of 1 for a pattern of 1 on boresight."""
        phase = -2.0 * np.pi * np.outer(along / self.length, self.positions)
        return np.asarray(np.cos(phase) @ np.array(self.weights))


def aperture_of(pattern: AntennaPattern, beamwidth: float, wavelength: float) -> Aperture | None:
    """The aperture of a horizontal pattern with a one-way half-power width [rad]; None for a pattern that is no line source."""
    source = line_source(pattern)
    if source is None:
        return None
    return Aperture(2.0 * source.half_power * wavelength / beamwidth, source.positions, source.weights)


def fresnel_unit(wavelength: float, distance: Floats | float) -> Floats:
    """Metres across the way of a plane wave in one unit of the Fresnel integrals, `distance` [m] behind an edge."""
    return np.sqrt(wavelength * np.asarray(distance) / 2.0)


def taken(structure: Structure, wavelength: float, aside: Floats, place: Floats) -> Complexes:
    """What a structure takes from a plane wave of field 1, at places of the aperture (N, M): the field there is 1 less this.

    aside: (N,) direction of the target from that of the structure, at most MAX_ASIDE either way [rad]; place: (M,) along the
    aperture to the right, as seen along the beam [m].
    """
    across, along = -structure.distance * np.sin(aside), structure.distance * np.cos(aside)
    unit = fresnel_unit(wavelength, along)[:, None]
    far, near = (fresnel_integral((across[:, None] + edge - place) / unit) for edge in (structure.radius, -structure.radius))
    below_top = half_plane(structure.top / unit)
    beyond = (np.abs(across) - structure.radius)[:, None] - np.abs(place).max()
    faded = np.clip((beyond / unit - TAPER_BEGIN) / (TAPER_END - TAPER_BEGIN), 0.0, 1.0)
    return np.asarray(np.exp(0.25j * np.pi) / np.sqrt(2.0) * (far - near) * below_top * np.cos(np.pi / 2.0 * faded) ** 2)


def half_plane(edge: Floats) -> Complexes:
    """Field of a plane wave behind a screen that is open below `edge` [Fresnel units], where 1 is the field without it."""
    return np.asarray(np.exp(0.25j * np.pi) / np.sqrt(2.0) * (fresnel_integral(edge) + (0.5 - 0.5j)))


def fresnel_integral(argument: Floats) -> Complexes:
    """C - j S of the Fresnel integrals, the integral of exp(-j pi t^2 / 2) from 0."""
    from scipy.special import fresnel  # here: scipy would slow the start of the service

    sine, cosine = fresnel(argument)
    return np.asarray(cosine - 1j * sine)
