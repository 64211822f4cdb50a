"""Patterns of radar reflectors in closed form: trihedral corners, the octahedral one made of eight, and the Luneburg lens.

A pattern is an effective area A, signed by the number of reflections; the cross-section is 4 pi A^2 / lambda^2. So it rises with
the square of the frequency. Three reflections make the lobes. Dihedrals of two plates and single plates flash where the
direction lies in a plane of the reflector or along its normal.
"""

import math

import numpy as np

from radar_service.numerics import SPEED_OF_LIGHT, Floats
from radar_service.radar import Radar
from radar_service.world import Reflector

REFERENCE_FREQUENCY = 9.41e9  # Hz, at which scene files state the cross-section of a reflector
# Legs of the trihedral that opens ahead (+y), axis level, one leg in the plane of symmetry: as `world.shapes.trihedral`.
_AHEAD, _UP, _SIDE = 1.0 / math.sqrt(3.0), 1.0 / math.sqrt(6.0), 1.0 / math.sqrt(2.0)
CORNER_LEGS = np.array([(0.0, _AHEAD, 2.0 * _UP), (_SIDE, _AHEAD, -_UP), (-_SIDE, _AHEAD, -_UP)])
# Catch-rain: the trihedral between the three legs opens up; its neighbours open 19.5 degrees above and below the horizon.
OCTAHEDRAL_LEGS = {
    "catch-rain": CORNER_LEGS[:, [0, 2, 1]] * (1.0, -1.0, 1.0),
    "point-up": np.array([(_SIDE, _SIDE, 0.0), (-_SIDE, _SIDE, 0.0), (0.0, 0.0, 1.0)]),
}


def reflector_area(reflector: Reflector, direction: Floats, polarization: Floats, wavelength: float) -> Floats:
    """Effective area (E,) [m^2] of a reflector, signed, so that 4 pi A^2 / lambda^2 is its cross-section.

    direction: (E, 3), unit vectors toward the radar in the body's frame; polarization: (E, 3), unit vectors of its electric field
    there; wavelength: [m].
    """
    if reflector.kind == "lens":
        return lens_area(direction[:, 1], reflector.size)
    octahedral = reflector.kind == "octahedral"
    legs = OCTAHEDRAL_LEGS[reflector.hung] if octahedral else CORNER_LEGS
    cosines = direction @ legs.T
    if not octahedral:
        return np.where(np.all(cosines > 0.0, axis=1), trihedral_area(np.maximum(cosines, 0.0), reflector.size), 0.0)
    area = trihedral_area(np.abs(cosines), reflector.size)
    area -= dihedral_area(cosines, polarization @ legs.T, reflector.size, wavelength)
    return area + plate_area(cosines, reflector.size, wavelength)


def trihedral_area(cosines: Floats, leg: float) -> Floats:
    """Effective area (E,) [m^2] of three reflections in a trihedral of triangular plates with legs `leg` [m].

    cosines: (E, 3) of the direction along its legs, not negative. 4 l m / (l + m + n) a^2 where l + m <= n, the largest, else
    (l + m + n - 2 / (l + m + n)) a^2; on the axis a^2 / sqrt(3) (Spencer 1944; Doerry 2014, Reflectors for SAR, eqs. 2, 3).
    """
    least, middle, largest = np.sort(cosines, axis=1).T
    total = np.maximum(least + middle + largest, 1e-12)
    return np.asarray(leg**2 * np.where(least + middle <= largest, 4.0 * least * middle / total, total - 2.0 / total))


def dihedral_area(cosines: Floats, polarization: Floats, leg: float, wavelength: float) -> Floats:
    """Effective area (E,) [m^2] of two reflections between two of three crossed square plates, all three pairs.

    cosines: (E, 3) of the direction along the legs; polarization: (E, 3), components of the field there. Where the direction is
    square to their common leg, a pair has 2 a^2 min(m, n); off it the legs' taper, 1 - |x| / a, gives sinc^2(k a l). Of the
    polarization that was sent, cos 2 psi is left, psi between field and leg (Ruck 1970, ch. 8).
    """
    total = np.zeros(len(cosines))
    for i in range(3):
        along, other, last = cosines[:, i], np.abs(cosines[:, i - 1]), np.abs(cosines[:, i - 2])
        kept = 2.0 * polarization[:, i] ** 2 / np.maximum(1.0 - along**2, 1e-12) - 1.0
        total += 2.0 * leg**2 * np.minimum(other, last) * np.sinc(2.0 * leg / wavelength * along) ** 2 * kept
    return total


def plate_area(cosines: Floats, leg: float, wavelength: float) -> Floats:
    """Effective area (E,) [m^2] of one reflection from each of three crossed square plates of diagonal 2 `leg` [m].

    cosines: (E, 3) of the direction along the legs. The area 2 a^2 projected, times sinc(k a (m + n)) sinc(k a (m - n)).
    """
    total = np.zeros(len(cosines))
    for i in range(3):
        m, n = cosines[:, i - 1] * (2.0 * leg / wavelength), cosines[:, i - 2] * (2.0 * leg / wavelength)
        total += 2.0 * leg**2 * np.abs(cosines[:, i]) * np.sinc(m + n) * np.sinc(m - n)
    return total


def lens_area(ahead: Floats, radius: float) -> Floats:
    """Effective area (E,) [m^2] of a Luneburg lens of `radius` [m] whose cap covers the half behind it.

    ahead: (E,), cosine between the direction and the lens's axis. A ray leaves through the mirror image of where it came in, and
    the cap covers a lune of the disc as the axis turns away: pi r^2 cos(theta), nothing from behind; 4 pi^3 r^4 / lambda^2 on the
    axis (Ruck 1970, ch. 8).
    """
    return np.asarray(np.pi * radius**2 * np.maximum(ahead, 0.0))


def peak_rcs(reflector: Reflector, wavelength: float) -> float:
    """Cross-section [m^2] at the peak of a lobe: on the axis of a trihedral or of the lens."""
    share = np.pi if reflector.kind == "lens" else 3.0**-0.5
    return float(4.0 * np.pi * (share * reflector.size**2) ** 2 / wavelength**2)


def highest_rcs(reflector: Reflector, wavelength: float) -> float:
    """A cross-section [m^2] that is never exceeded: of an octahedral one by its plates, square on."""
    if reflector.kind != "octahedral":
        return peak_rcs(reflector, wavelength)
    return float(4.0 * np.pi * (2.0 * reflector.size**2) ** 2 / wavelength**2)


def size_of(kind: str, rcs: float) -> float:
    """Leg or radius [m] of a reflector whose lobes peak at a cross-section `rcs` [m^2] at REFERENCE_FREQUENCY."""
    unit = peak_rcs(Reflector(kind, 1.0), SPEED_OF_LIGHT / REFERENCE_FREQUENCY)
    return float((rcs / unit) ** 0.25)


def reflector_text(reflector: Reflector, radar: Radar) -> str:
    """A reflector in a few words, with the peak of its lobes at the frequency of a radar."""
    measure = "radius" if reflector.kind == "lens" else "legs"
    hung = f", hung {reflector.hung}" if reflector.kind == "octahedral" else ""
    kind = "Luneburg lens" if reflector.kind == "lens" else f"{reflector.kind} reflector"
    peak = peak_rcs(reflector, radar.wavelength)
    return f"{kind}, {measure} {reflector.size:.3g} m{hung}, lobes of {peak:.3g} m2 at {radar.frequency / 1e9:.4g} GHz"
