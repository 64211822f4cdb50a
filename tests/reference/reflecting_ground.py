"""The two-ray factor over water and land, point by point: the point of reflection is sought along the profile of each way.

Slow and plain: the ground is a function of the distance, which is sampled, and the angles of both rays against it are compared.
Fresnel's coefficients and roughness are written out here (Barton, Radar Equations for Modern Radar, 2013, ch. 8; Kerr 1951).
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

WAVELENGTH = 299_792_458.0 / 9.41e9
SEA = 55.3 - 38.2j  # relative permittivity of sea water at 15 degrees C and 9.41 GHz (docs/accuracy.md)
STEP = 0.25  # m between samples of a profile


class Piece(NamedTuple):
    """What reflects up to a distance: height [m], permittivity (0: nothing reflects there), rms height of its surface [m]."""

    end: float
    height: float
    permittivity: complex
    rough: float


def water(end: float) -> Piece:
    """A calm sea up to a distance [m]."""
    return Piece(end, 0.0, SEA, 0.0)


def angles(x: Any, d: float, h: float, antenna: float, up: float, earth: float) -> tuple[Any, Any]:
    """By how much both rays rise over the ground at x, one or many, which is `up` above the sea [rad]."""
    at = up - x * x / (2.0 * earth)
    first = np.arctan2(antenna - at, x) - x / earth
    return first, np.arctan2(h - d * d / (2.0 * earth) - at, d - x) + x / earth


def reflection(d: float, h: float, antenna: float, profile: Sequence[Piece], earth: float) -> tuple[float, Piece] | None:
    """Where rays at both sides rise by one angle over the ground, and what is there; of several the lowest piece."""
    found, begin = [], 0.0
    for piece in profile:
        end = min(piece.end, d)

        def tilted(x: Any, up: float = piece.height) -> Any:
            first, second = angles(x, d, h, antenna, up, earth)
            return first - second

        x = np.append(np.arange(max(begin, 1e-3), end, STEP), end - 1e-9)
        falls = tilted(x) > 0.0
        for k in np.flatnonzero(falls[:-1] & ~falls[1:]):
            found.append((float(brentq(tilted, x[k], x[k + 1], xtol=1e-9)), piece))
        begin = end
    found = [(x, piece) for x, piece in found if min(angles(x, d, h, antenna, piece.height, earth)) > 0.0]
    return min(found, key=lambda each: each[1].height) if found else None


def factor(
    d: float, h: float, antenna: float, profile: Sequence[Piece], earth: float = np.inf, polarization: str = "h",
    gain: Callable[[float], float] = lambda elevation: 1.0,
) -> complex:  # fmt: skip
    """F over the direct ray of a target at a distance d along the earth and a height h above the sea [m].

    gain: one-way, of power, at an elevation [rad].
    """
    place = reflection(d, h, antenna, profile, earth)
    if place is None or place[1].permittivity == 0.0:
        return 1.0 + 0.0j
    x, ground = place
    low, top = ground.height - x * x / (2.0 * earth), h - d * d / (2.0 * earth)
    first, second, direct = np.hypot(x, antenna - low), np.hypot(d - x, top - low), np.hypot(d, antenna - top)
    grazing, _ = angles(x, d, h, antenna, ground.height, earth)
    sine, cosine, e = np.sin(grazing), np.cos(grazing), ground.permittivity
    root = np.sqrt(e - cosine**2 + 0.0j)
    fresnel = (sine - root) / (sine + root) if polarization == "h" else (e * sine - root) / (e * sine + root)
    rough = np.exp(-8.0 * (np.pi * ground.rough * sine / WAVELENGTH) ** 2)
    spread = 1.0 / np.sqrt(1.0 + 2.0 * x * (d - x) / (earth * d * sine))
    way = np.exp(-2j * np.pi / WAVELENGTH * (first + second - direct)) * direct / (first + second)
    beam = np.sqrt(gain(np.arctan2(low - antenna, x)) / gain(np.arctan2(top - antenna, d)))
    return complex(1.0 + fresnel * rough * spread * way * beam)
