"""Own ship's structures near the antenna: what a mast or a funnel takes from the beam, by diffraction in closed form and tables.

A structure is an upright opaque cylinder of radius a at distance d, which stands as a black strip of width 2 a across the way of
the waves (Kirchhoff; Babinet). An antenna of length D is far inside its near field there: D^2 / lambda is 230 m for 2.7 m in X
band. So each element of the aperture has the Fresnel integrals of the strip's edges of its own, and the pattern is their sum over
the aperture. Source: Born and Wolf, Principles of Optics, 1999, 8.7.3; ITU-R P.526-15, 4.1 (knife edge) and 5.2 (screens).
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics import Complexes, Flags, Floats, Indices, wrap_angle
from radar_service.radar import MAX_OFFSET, Aperture

MAX_ASIDE = np.radians(80.0)  # from a structure's bearing; beyond, nothing of it stands before the aperture
TAPER_BEGIN, TAPER_END = 6.0, 8.0  # Fresnel units beyond the last edge, over which ripples of 0.4 dB at most are faded out
STEPS_PER_UNIT = 20  # of the direction, in a Fresnel unit of an edge's shadow
STEPS_PER_NULL = 36  # of the offset, in lambda / D: linear interpolation errs by (pi / 36)^2 / 8, -60 dB of boresight
ELEMENTS_PER_CYCLE = 8  # of the aperture, in a cycle of its phase at the outermost offset
MIN_ELEMENTS = 256


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


class TakenTable:
    """What one structure takes from the pattern, by linear interpolation in direction and offset."""

    def __init__(self, structure: Structure, aperture: Aperture, wavelength: float, extent: float) -> None:
        """extent: offset from boresight up to which the table reaches [rad]."""
        self.bearing = structure.bearing
        extent = min(extent, MAX_OFFSET)
        per_unit = float(fresnel_unit(wavelength, structure.distance))
        reach = 0.5 * aperture.length + structure.radius + TAPER_END * per_unit
        self.reach = min(MAX_ASIDE, float(np.arcsin(min(1.0, reach / structure.distance))))
        asides = 2 * int(np.ceil(self.reach * structure.distance / per_unit * STEPS_PER_UNIT)) + 1
        aside = np.linspace(-self.reach, self.reach, asides)
        offsets = 2 * int(np.ceil(extent * aperture.length / wavelength * STEPS_PER_NULL)) + 1
        offset = np.linspace(-extent, extent, offsets)
        cycles = aperture.length / wavelength * offset
        elements = max(MIN_ELEMENTS, int(np.ceil(ELEMENTS_PER_CYCLE * cycles[-1])))
        place = ((np.arange(elements) + 0.5) / elements - 0.5) * aperture.length
        lit = taken(structure, wavelength, aside, place) * aperture.illumination(place) / elements
        phase = np.exp(2j * np.pi * np.outer(place / aperture.length, cycles))
        self._field = (lit @ phase).astype(np.complex64)
        self._aside = aside[0], (asides - 1) / (2.0 * self.reach)
        self._offset, self.extent = (offset[0], (offsets - 1) / (2.0 * extent)), extent

    def subtract(self, field: Complexes, from_bow: Floats, offset: Floats) -> None:
        """Subtracts what the structure takes from a field (any shape), in place; from_bow, offset: as of `FieldChange`."""
        aside = wrap_angle(from_bow - self.bearing)
        behind = np.nonzero((np.abs(aside) < self.reach) & (np.abs(offset) < self.extent))
        if not len(behind[0]):
            return
        row, up = _cells(aside[behind], *self._aside)
        column, right = _cells(offset[behind], *self._offset)
        table = self._field
        lower = table[row, column] * (1.0 - right) + table[row, column + 1] * right
        upper = table[row + 1, column] * (1.0 - right) + table[row + 1, column + 1] * right
        field[behind] -= lower * (1.0 - up) + upper * up

    def reaches(self, from_bow: Floats) -> Flags:
        """To which directions (E,) from the bow [rad] the structure changes the field."""
        return np.asarray(np.abs(wrap_angle(from_bow - self.bearing)) < self.reach)


def _cells(values: Floats, first: float, per_radian: float) -> tuple[Indices, Floats]:
    """The entry (E,) below each value (E,), and how far on to the next one it is, from 0 to 1."""
    position = (values - first) * per_radian
    entry = position.astype(np.intp)
    return entry, position - entry
