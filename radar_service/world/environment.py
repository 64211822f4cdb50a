"""The environment: the earth, the air and the sea, and attenuation by the gases of the air near the ground."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from radar_service.numerics import KNOT, Floats, bearing_text
from radar_service.radar import Radar
from radar_service.world.error import SceneError
from radar_service.world.seaway import NO_STREAM, Seaway, Stream

# Attenuation by gases is that of Recommendation ITU-R P.676-10 (2013), Annex 2, whose approximate formulas are for sea
# level. Their error against the sum over all lines (P.676-12, Annex 1; 0.01327 dB/km at 9.41 GHz) is 2 % at X band, and up
# to 8 % elsewhere below 54 GHz.
PRESSURE_HPA = 1013.25
TEMPERATURE = 288.15  # K
VAPOUR_G_M3 = 7.5
MAX_FREQUENCY = 54e9  # Hz: the oxygen lines at 60 GHz have other formulas


def gas_attenuation_db_per_km(frequency: float) -> float:
    """Returns one-way attenuation [dB/km] at `frequency` [Hz] in air of 1013.25 hPa, 15 C, 7.5 g/m3 of water vapour.

    The sum of oxygen and water vapour (P.676-10, Annex 2, eqs. 22a and 23a). Raises SceneError below 1 and above 54 GHz.
    """
    if not 1e9 <= frequency <= MAX_FREQUENCY:
        raise SceneError(f'environment.gas_db_per_km: "itu" covers 1 to 54 GHz, not {frequency / 1e9:g} GHz; give a number')
    f = frequency / 1e9
    return oxygen_db_per_km(f) + vapour_db_per_km(f)


def oxygen_db_per_km(f_ghz: float) -> float:
    """Returns the attenuation by dry air [dB/km] below 54 GHz (P.676-10, Annex 2, eq. 22a)."""
    p, t = PRESSURE_HPA / 1013.0, 288.0 / TEMPERATURE
    xi1 = _phi(p, t, 0.0717, -1.8132, 0.0156, -1.6515)
    xi2 = _phi(p, t, 0.5146, -4.6368, -0.1921, -5.7416)
    xi3 = _phi(p, t, 0.3414, -6.5851, 0.2130, -8.5854)
    debye = 7.2 * math.pow(t, 2.8) / (f_ghz**2 + 0.34 * p**2 * math.pow(t, 1.6))
    lines = 0.62 * xi3 / (math.pow(54.0 - f_ghz, 1.16 * xi1) + 0.83 * xi2)
    return (debye + lines) * f_ghz**2 * p**2 * 1e-3  # eq. 22a


def _phi(p: float, t: float, a: float, b: float, c: float, d: float) -> float:
    return math.pow(p, a) * math.pow(t, b) * math.exp(c * (1.0 - p) + d * (1.0 - t))  # P.676-10 Annex 2, eq. 22u


# Line [GHz], strength, exponent of temperature, width factor (0: the far wing alone), line of the shape factor g (None: 1).
_LINES = (
    (22.235, 3.98, 2.23, 9.42, 22.0),
    (183.31, 11.96, 0.7, 11.14, None),
    (321.226, 0.081, 6.44, 6.29, None),
    (325.153, 3.66, 1.6, 9.22, None),
    (380.0, 25.37, 1.09, 0.0, None),
    (448.0, 17.4, 1.46, 0.0, None),
    (557.0, 844.6, 0.17, 0.0, 557.0),
    (752.0, 290.0, 0.41, 0.0, 752.0),
)


def vapour_db_per_km(f_ghz: float) -> float:
    """Returns the attenuation by water vapour [dB/km] (P.676-10, Annex 2, eqs. 23a to 23d)."""
    p, t = PRESSURE_HPA / 1013.0, 288.0 / TEMPERATURE
    eta1 = 0.955 * p * math.pow(t, 0.68) + 0.006 * VAPOUR_G_M3  # eq. 23b
    eta2 = 0.735 * p * math.sqrt(t) + 0.0353 * t**4 * VAPOUR_G_M3  # eq. 23c
    total = 8.3328e4 * eta2 * math.exp(0.99 * (1.0 - t)) / (f_ghz - 1780.0) ** 2 * _shape(f_ghz, 1780.0)
    for line, strength, exponent, width, shaped in _LINES:
        term = strength * eta1 * math.exp(exponent * (1.0 - t)) / ((f_ghz - line) ** 2 + width * eta1**2)
        total += term * (1.0 if shaped is None else _shape(f_ghz, shaped))
    return total * f_ghz**2 * math.pow(t, 2.5) * VAPOUR_G_M3 * 1e-4  # eq. 23a


def _shape(f_ghz: float, line: float) -> float:
    return 1.0 + ((f_ghz - line) / (f_ghz + line)) ** 2  # eq. 23d


class SightLines(NamedTuple):
    """Straight ways from the antenna to targets (E,).

    antenna: (3,) or (E, 3) on the map [m]; time: one or (E,) [s]; azimuth: (E,) [rad]; distance: slant range (E,) [m].
    """

    antenna: Floats
    time: Floats | float
    azimuth: Floats
    distance: Floats


class Attenuator:
    """What attenuates by place and time. An environment has those among the values of effects' keys."""

    def one_way_db(self, radar: Radar, lines: SightLines) -> Floats:
        """Returns its attenuation (E,) [dB] of a radar's wave along each line."""
        raise NotImplementedError

    @property
    def text(self) -> str:
        """What it is, in a few words."""
        raise NotImplementedError


@dataclass(frozen=True)
class Environment:
    """The earth, the atmosphere and the sea, in SI units; see EnvironmentModel."""

    earth_factor: float  # effective earth radius over the earth's radius; inf is flat
    noise: bool
    multipath: bool
    gas_db_per_km: float  # one way; a number also where the scene has "itu"
    rain_mm_h: float
    sea_state: float  # also where the scene has wave_height_m; 0 for no sea
    effect_keys: Mapping[str, Any] = field(hash=False)  # values of effects' keys, by key
    wind_from: float
    ground_plane: bool
    diffraction: bool = field(default=False, metadata={"added": True})
    seaway: Seaway | None = field(default=None, metadata={"added": True})  # that moves ships
    stream: Stream = field(default=NO_STREAM, metadata={"added": True})  # of the water over ground, east and north [m/s]

    @property
    def texts(self) -> list[str]:
        """What it has, in a few words each, but for effects' keys."""
        texts = [name for name in ("noise", "multipath", "diffraction", "ground_plane") if getattr(self, name)]
        texts += [f"gas {self.gas_db_per_km:.4g} dB/km one way"] if self.gas_db_per_km else []
        texts += [f"rain {self.rain_mm_h:g} mm/h"] if self.rain_mm_h else []
        texts += [f"sea state {self.sea_state:.3g}"] if self.sea_state else []
        if self.seaway is not None:
            coming_from = bearing_text(self.seaway.towards + math.pi)
            texts.append(f"waves of {self.seaway.height:.3g} m in {self.seaway.period:.3g} s from {coming_from} move ships")
        if any(self.stream):
            texts.append(f"stream of {math.hypot(*self.stream) / KNOT:.3g} kn to {bearing_text(math.atan2(*self.stream))}")
        return texts

    @cached_property
    def attenuators(self) -> tuple[Attenuator, ...]:
        """What attenuates by place and time."""
        return tuple(value for value in self.effect_keys.values() if isinstance(value, Attenuator))
