"""Attenuation by gas and rain along the path."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Floats


def printed_atmosphere(range: Floats | float, db_per_km: float = 0.01) -> Floats:
    """Two-way POWER loss exactly as printed, by which the specification multiplies the amplitude
    (docs/specification.md, errata row 3).

    range: slant range, any shape [m]; db_per_km: one way. Source: docs/specification.md eq. 10.
    """
    return 10.0 ** (-db_per_km * 2.0 * np.asarray(range, dtype=np.float64) / (10.0 * 1000.0))  # eq. 10


def attenuation_amplitude(range: Floats | float, db_per_km: float) -> Floats:
    """Two-way AMPLITUDE factor 10^(-gamma 2R / 20 000) of a uniform attenuation, gas or rain
    (docs/specification.md, errata row 3).

    range: slant range, any shape [m]; db_per_km: one way; the sum of several attenuations.
    """
    return 10.0 ** (-db_per_km * 2.0 * np.asarray(range, dtype=np.float64) / 20_000.0)


class _RainFit(NamedTuple):
    """Curve sum a exp(-((x - b) / c)^2) + m x + c0 over x = log10 of the frequency in GHz (P.838-3 eqs. 2, 3)."""

    a: tuple[float, ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    slope: float
    offset: float

    def at(self, x: float) -> float:
        bumps = (a * np.exp(-(((x - b) / c) ** 2)) for a, b, c in zip(self.a, self.b, self.c, strict=True))
        return float(sum(bumps)) + self.slope * x + self.offset


# Tables 1 to 4 of Rec. ITU-R P.838-3 (2005): log10 k and alpha by polarization.
_RAIN_LOG_K = {
    "h": _RainFit(
        (-5.33980, -0.35351, -0.23789, -0.94158),
        (-0.10008, 1.26970, 0.86036, 0.64552),
        (1.13098, 0.45400, 0.15354, 0.16817),
        -0.18961,
        0.71147,
    ),
    "v": _RainFit(
        (-3.80595, -3.44965, -0.39902, 0.50167),
        (0.56934, -0.22911, 0.73042, 1.07319),
        (0.81061, 0.51059, 0.11899, 0.27195),
        -0.16398,
        0.63297,
    ),
}
_RAIN_ALPHA = {
    "h": _RainFit(
        (-0.14318, 0.29591, 0.32177, -5.37610, 16.1721),
        (1.82442, 0.77564, 0.63773, -0.96230, -3.29980),
        (-0.55187, 0.19822, 0.13164, 1.47828, 3.43990),
        0.67849,
        -1.95537,
    ),
    "v": _RainFit(
        (-0.07771, 0.56727, -0.20238, -48.2991, 48.5833),
        (2.33840, 0.95545, 1.14520, 0.791669, 0.791459),
        (-0.76284, 0.54039, 0.26809, 0.116226, 0.116479),
        -0.053739,
        0.83433,
    ),
}


@lru_cache(maxsize=16)  # a radar asks for its own frequency at each block of azimuths
def rain_db_per_km(rain_mm_h: float, polarization: str, frequency: float) -> float:
    """One-way specific attenuation of rain [dB/km], k R^alpha on a level path (Rec. ITU-R P.838-3, 2005, eq. 1).

    rain_mm_h: 0 and up; polarization: "h" or "v"; frequency: 1e9 to 1000e9 [Hz]. Raises ValueError outside.
    """
    if polarization not in _RAIN_LOG_K:
        raise ValueError(f'polarization: "{polarization}" is not one of {", ".join(_RAIN_LOG_K)}')
    if not 1e9 <= frequency <= 1e12:
        raise ValueError(f"frequency: {frequency:g} Hz is outside the 1e9 to 1e12 Hz of ITU-R P.838-3")
    if not rain_mm_h >= 0:
        raise ValueError(f"rain_mm_h: {rain_mm_h:g} is not allowed; 0 mm/h or more")
    x = np.log10(frequency / 1e9)
    return float(10.0 ** _RAIN_LOG_K[polarization].at(x) * rain_mm_h ** _RAIN_ALPHA[polarization].at(x))
