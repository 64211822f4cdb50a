"""The antenna patterns that a scene can name: that of the specification and those of real apertures.

To add one: write its class here and enter it in PATTERNS. Loader, grid, plan and engine use only the object.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from typing_extensions import override

from radar_service.numerics import Floats
from radar_service.radar.antenna import AntennaPattern

HALF_POWER_U = 0.442946470689452  # root of sinc(u)^2 = 1/2; twice it is the 0.8859 of the half-power width
MIN_GAIN = 1e-30  # -300 dB: keeps the logarithm of a table's zeros finite


class LineSource(NamedTuple):
    """A cosine-sum aperture as shifted sincs: their positions u, their weights, and the u of half power."""

    positions: tuple[float, ...]
    weights: tuple[float, ...]
    half_power: float


def printed_gain(offset: Floats | float, beamwidth: float) -> Floats:
    """One-way gain exactly as printed, u = 2.783 t / t3dB inside sin(pi u) / (pi u); its half-power width is 0.318 t3dB.

    offset: any shape, from boresight [rad]; beamwidth: nominal one-way half-power width [rad]. Source:
    docs/specification.md eq. 2.
    """
    u = 2.783 * np.asarray(offset, dtype=np.float64) / beamwidth
    return np.sinc(u) ** 2  # eq. 2, with G0 = 1


def printed_two_way(azimuth: Floats | float, elevation: Floats | float, beamwidth: float, beamwidth_el: float) -> Floats:
    """Two-way pattern exactly as printed, by which the specification multiplies the AMPLITUDE
    (docs/specification.md, errata row 2).

    azimuth, elevation: offsets from boresight, broadcastable [rad]; the beamwidths one-way [rad]. Source:
    docs/specification.md eqs. 3, 9.
    """
    return (printed_gain(azimuth, beamwidth) * printed_gain(elevation, beamwidth_el)) ** 2  # eqs. 3, 9


@dataclass(frozen=True)
class Sinc2(AntennaPattern):
    """Uniform aperture: sinc^2 with u = 0.8859 t / t3dB, first sidelobe -13.26 dB (Balanis, Antenna Theory, 2016)."""

    name = "sinc2"
    aperture_width = 1.0

    @override
    def gain(self, offset: Floats | float, beamwidth: float) -> Floats:
        return np.sinc(2.0 * HALF_POWER_U / beamwidth * np.asarray(offset, dtype=np.float64)) ** 2


@dataclass(frozen=True)
class Printed(AntennaPattern):
    """The specification's pattern, narrower than its nominal beamwidth (docs/specification.md eq. 2)."""

    name = "printed"
    aperture_width = 2.783 / (2.0 * HALF_POWER_U)  # of the uniform aperture that has the nominal beamwidth

    @override
    def gain(self, offset: Floats | float, beamwidth: float) -> Floats:
        return printed_gain(offset, beamwidth)


@dataclass(frozen=True)
class Gaussian(AntennaPattern):
    """Gaussian beam, without sidelobes."""

    name = "gaussian"
    aperture_width = 1.0

    @override
    def gain(self, offset: Floats | float, beamwidth: float) -> Floats:
        gain: Floats = np.exp(-4.0 * np.log(2.0) * (np.asarray(offset, dtype=np.float64) / beamwidth) ** 2)
        return gain


class CosineSum(AntennaPattern):
    """A line source whose illumination is a sum of cosines, stretched to the half-power width."""

    @property
    @abstractmethod
    def source(self) -> LineSource:
        """The illumination."""

    @property
    @override
    def aperture_width(self) -> float:
        return self.source.half_power / HALF_POWER_U

    @override
    def gain(self, offset: Floats | float, beamwidth: float) -> Floats:
        u = 2.0 * self.source.half_power / beamwidth * np.asarray(offset, dtype=np.float64)
        return sinc_sum(u, self.source.positions, self.source.weights) ** 2


@dataclass(frozen=True)
class Cosine(CosineSum):
    """Cosine aperture: first sidelobe -23.0 dB, half-power width 1.189 lambda / a (Balanis, Antenna Theory, 2016)."""

    name = "cosine"

    @cached_property
    @override
    def source(self) -> LineSource:
        return _line_source((-0.5, 0.5), (np.pi / 4.0, np.pi / 4.0))


@dataclass(frozen=True)
class Cosine2(CosineSum):
    """Cosine-squared aperture: first sidelobe -31.5 dB, half-power width 1.441 lambda / a (Balanis 2016; Harris 1978)."""

    name = "cosine2"

    @cached_property
    @override
    def source(self) -> LineSource:
        return _line_source((-1.0, 0.0, 1.0), (0.5, 1.0, 0.5))


@dataclass(frozen=True)
class Taylor(CosineSum):
    """Taylor line source (T. T. Taylor, 1955).

    sidelobe_db: level of the sidelobes below the peak [dB]; nbar: one more than the number of equal sidelobes.
    """

    sidelobe_db: float = 30.0
    nbar: int = 4  # the minimum for 30 dB
    name = "taylor"

    @property
    @override
    def description(self) -> str:
        return f"taylor {self.sidelobe_db:g} dB, nbar {self.nbar}"

    @cached_property
    def source(self) -> LineSource:
        """F_n at u = n, n = -(nbar - 1) to nbar - 1 (Taylor 1955)."""
        nbar = self.nbar
        a2 = (np.arccosh(10.0 ** (self.sidelobe_db / 20.0)) / np.pi) ** 2
        sigma2 = nbar**2 / (a2 + (nbar - 0.5) ** 2)
        m = np.arange(1, nbar)
        n = np.arange(nbar)
        column = n[:, None]
        zeros = np.prod(1.0 - column**2 / (sigma2 * (a2 + (m - 0.5) ** 2)), axis=1)
        others = np.where(m == column, 1.0, 1.0 - column**2 / m**2).prod(axis=1)
        own = np.where(n == 0, 1.0, 0.5 * (-1.0) ** (n + 1))  # sinc(u) / (1 - u^2 / n^2) as u goes to n
        weights = (zeros / others * own).tolist()
        return _line_source((*(-n[:0:-1]).tolist(), *n.tolist()), (*weights[:0:-1], *weights))


@dataclass(frozen=True)
class Table(AntennaPattern):
    """A measured pattern: rows of (offset [rad], one-way power gain), rising from 0; the last gain applies beyond.

    Between rows the level in dB is a monotone cubic (Fritsch and Carlson 1980), flat at boresight. Straight lines would leave
    corners: the band of the beam filter cuts their spectrum at -50 dB, and the error of the beam would be 12 dB larger.
    """

    rows: tuple[tuple[float, float], ...]
    name = "table"
    aperture_width = 1.7  # slightly more than a cosine-squared taper

    @property
    @override
    def description(self) -> str:
        return f"a table of {len(self.rows)} rows"

    @override
    def gain(self, offset: Floats | float, beamwidth: float = np.nan) -> Floats:
        """A table has its own beamwidth."""
        inside = np.minimum(np.abs(offset), self.rows[-1][0])
        return 10.0 ** self._curve(inside)

    def half_power_width(self, beamwidth: float) -> float:
        """The table's own [rad], to 2 x 31 microradians; a full circle where the gain never falls to one half."""
        return self._half_power_width

    @cached_property
    def _half_power_width(self) -> float:
        fine = np.linspace(0.0, np.pi, 100_001)
        below = np.flatnonzero(self.gain(fine) < 0.5)
        return 2.0 * float(fine[below[0]]) if len(below) else 2.0 * np.pi

    @cached_property
    def _curve(self) -> Callable[[Floats], Floats]:
        """log10 of the gain over the offset [rad], symmetric about 0 and flat at its end."""
        from scipy.interpolate import PchipInterpolator  # here: it would slow every start by a sixth

        offset, gain = np.asarray(self.rows, dtype=np.float64).T
        level = np.log10(np.maximum(gain, MIN_GAIN))
        beyond = 2.0 * offset[-1] - offset[-2]
        return PchipInterpolator(
            np.concatenate([-offset[:0:-1], offset, [beyond]]), np.concatenate([level[:0:-1], level, level[-1:]])
        )


PATTERNS: Mapping[str, AntennaPattern] = MappingProxyType(
    {pattern.name: pattern for pattern in (Sinc2(), Printed(), Gaussian(), Taylor(), Cosine(), Cosine2())}
)


def line_source(pattern: AntennaPattern) -> LineSource | None:
    """Returns the illumination of a pattern's aperture; None for patterns that are no sum of cosines."""
    if isinstance(pattern, Sinc2):
        return LineSource((0.0,), (1.0,), HALF_POWER_U)
    return pattern.source if isinstance(pattern, CosineSum) else None


def _line_source(positions: tuple[float, ...], weights: tuple[float, ...]) -> LineSource:
    low, high = 0.1, 1.5  # the main lobe passes half power once in between
    for _ in range(4):  # to 1e-12; scipy.optimize takes a tenth of a second to load
        u = np.linspace(low, high, 1025)
        above = int(np.flatnonzero(sinc_sum(u, positions, weights) > np.sqrt(0.5))[-1])
        low, high = float(u[above]), float(u[above + 1])
    return LineSource(positions, weights, (low + high) / 2.0)


def sinc_sum(u: Floats, positions: tuple[float, ...], weights: tuple[float, ...]) -> Floats:
    """Returns the voltage pattern (any shape) of a cosine-sum aperture: shifted sincs, which have no removable singularities."""
    field = np.zeros(np.shape(u))
    for position, weight in zip(positions, weights, strict=True):
        field += weight * np.sinc(u - position)
    return field
