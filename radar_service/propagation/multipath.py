"""Multipath: the ray that the sea reflects, or a plane in its place, beside the direct one.

Positions are as in `frames`: a distance along the earth and a height above the sea, whose surface is z = -d^2 / (2 ae).
Phases follow exp(+j w t): a path of length R multiplies the field by exp(-j k R).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import SPEED_OF_LIGHT, Complexes, Flags, Floats, Gain, Profiles, Singles
from radar_service.propagation.sea_surface import ament, fresnel, miller_brown, sea_water_permittivity

Roughness = Callable[[Floats, Floats | float, float], Floats]  # grazing angle, rms height of waves, wavelength -> factor

Site = tuple[Floats, Floats, Floats]  # distances along the earth, heights of targets, and the antenna's height [m]

_TINY = 1e-300  # m^2: avoids 0 / 0 for a target at the foot of the antenna
MIN_GAIN = 1e-12  # -120 dB: a lower direct gain counts as this one, so that the ratio stays finite in a null of the beam


def wavelength(frequency: float) -> float:
    """Free-space wavelength [m] of a frequency [Hz], 0.03186 m at 9.41 GHz. Source: docs/specification.md eq. 1."""
    return SPEED_OF_LIGHT / frequency  # eq. 1


class SpecularGeometry(NamedTuple):
    """Direct and reflected ray, arrays of one shape; elevations are from horizontal, at the antenna.

    direct: R, length of the direct ray [m].
    first: R1, from antenna to sea [m].
    second: R2, from sea to target [m].
    excess: R1 + R2 - R [m].
    grazing: angle at the sea [rad]; negative below the horizon, where the other fields have no meaning.
    divergence: factor D of the curved surface, 1 on a flat one.
    elevation_direct: of the direct ray [rad].
    elevation_reflected: of the reflected ray [rad].
    reflection: distance of the reflection point from the antenna, along the earth [m].
    """

    direct: Floats
    first: Floats
    second: Floats
    excess: Floats
    grazing: Floats
    divergence: Floats
    elevation_direct: Floats
    elevation_reflected: Floats
    reflection: Floats

    @property
    def excess_slope(self) -> Floats:
        """Change of the excess with the target's height: difference of the sines of both rays at the target (Fermat)."""
        return np.asarray(np.sin(2.0 * self.grazing + self.elevation_reflected) - np.sin(self.elevation_direct))


class TwoRays(NamedTuple):
    """The direct ray and the ray by the sea with their fields, arrays of one shape.

    geometry: of both rays.
    gain: one-way power gain of the direct ray in elevation, at least MIN_GAIN.
    ratio: Gamma rho_s D R / (R1 + R2) sqrt(G(reflected) / G(direct)), the field by the sea over the direct one without its
        phase exp(-jk (R1 + R2 - R)).
    share: of ray optics in the ratio: 1, or less where diffraction over the sea counts.
    level: height above the sea of what reflects, above which the geometry has its heights [m].
    """

    geometry: SpecularGeometry
    gain: Floats
    ratio: Complexes
    share: Floats
    level: Floats | float = 0.0

    @property
    def arrives(self) -> Flags:
        """Where a field arrives: before the horizon, and beyond it by diffraction."""
        return np.asarray((self.geometry.grazing > 0.0) | (self.share < 1.0))


def specular_geometry(
    distance: Floats | float, height: Floats | float, antenna_height: Floats | float, earth_radius: float = np.inf
) -> SpecularGeometry:
    """Geometry of the specular reflection between an antenna and targets over a flat sea or over z = -d^2 / (2 ae).

    distance: along the earth, any shape [m]; height: of the target above the sea, negative ones count as 0 [m];
    antenna_height: above the sea, positive [m]; earth_radius: effective radius ae [m], inf for flat. The reflection point
    solves the cubic of Kerr (Propagation of Short Radio Waves, 1951, ch. 2); by Fermat its error enters in second order.
    """
    d, h = np.asarray(distance, np.float64), np.maximum(np.asarray(height, np.float64), 0.0)
    if d.shape != h.shape:
        d, h = np.broadcast_arrays(d, h)
    x = reflection_distance(d, h, antenna_height, earth_radius)
    direct, first, second, excess, rise, z = _lengths(x, d, h, antenna_height, earth_radius)
    grazing = np.arctan2(antenna_height - x * x / (2.0 * earth_radius), x)
    return SpecularGeometry(
        direct, first, second, excess, grazing, divergence(x, d - x, grazing, earth_radius),
        np.arctan2(z, d), np.arctan2(-rise, x), x,
    )  # fmt: skip


def moved_excess(geometry: SpecularGeometry, before: Site, after: Site, earth_radius: float) -> Floats:
    """Excess R1 + R2 - R [m] after small moves, without solving for the reflection point anew.

    before, after: distance along the earth, height and antenna height above the sea [m]. The reflection point moves as over
    a flat sea. By Fermat its error counts in second order: below 1e-6 m for moves by 2 m and heights by 0.3 m.
    """
    (d, h, antenna_height), (old_d, old_h, old_antenna) = after, before
    h, old_h = np.maximum(h, 0.0), np.maximum(old_h, 0.0)
    moved = d * antenna_height / (antenna_height + h) - old_d * old_antenna / (old_antenna + old_h)
    return _lengths(_between(geometry.reflection + moved, d), d, h, antenna_height, earth_radius)[3]


def _lengths(x: Floats, d: Floats, h: Floats, antenna_height: Floats | float, earth_radius: float) -> tuple[Floats, ...]:
    """R, R1, R2 and R1 + R2 - R by a reflection point at x, the fall of R1, and the rise of R, all [m]."""
    beyond, drop, bulge = d - x, d * d / (2.0 * earth_radius), x * x / (2.0 * earth_radius)
    rise_1, rise_2, z = antenna_height + bulge, h - drop + bulge, h - drop - antenna_height
    direct, first, second = np.sqrt(d * d + z * z), np.sqrt(x * x + rise_1**2), np.sqrt(beyond * beyond + rise_2**2)
    # R1 + R2 - R without the difference of large lengths: it is millimetres, and k times it must be accurate to 1e-6 rad
    cross = (x * rise_2) ** 2 + (beyond * rise_1) ** 2 + (rise_1 * rise_2) ** 2
    gap = 2.0 * (rise_1 * rise_2 + cross / (first * second + x * beyond + _TINY))
    return direct, first, second, gap / (first + second + direct), rise_1, z


def divergence(first: Floats, second: Floats, grazing: Floats, earth_radius: float) -> Floats:
    """Divergence factor D of a ray reflected by the curved sea, from 1 (flat) to 0 at the horizon.

    first, second: ground distances from antenna and target to the reflection point [m]; grazing: [rad], D is 0 where it is
    not positive; earth_radius: ae [m], inf for flat. D = (1 + 2 d1 d2 / (ae d sin psi))^-1/2 (Kerr 1951, ch. 5).
    """
    sine = np.sin(grazing)
    fall = (first + second) * sine
    split = first * second / np.where(fall > 0.0, fall, 1.0)  # 0 at the foot of the antenna
    return np.where(sine > 0.0, 1.0 / np.sqrt(1.0 + 2.0 * split / earth_radius), 0.0)


def two_rays(
    distance: Floats | float,
    height: Floats | float,
    antenna_height: Floats | float,
    wavelength: float,
    *,
    earth_radius: float = np.inf,
    polarization: str = "h",
    wave_height: Floats | float = 0.0,
    elevation_gain: Gain | None = None,
    roughness: Roughness = miller_brown,
    permittivity: Floats | None = None,
) -> TwoRays:
    """The direct ray to each target and the ray by the sea, with their fields.

    distance: along the earth, any shape [m]; height: above the sea [m]; antenna_height, wavelength: [m]; earth_radius: ae
    [m]; polarization: "h" or "v"; wave_height: rms of the sea [m]; elevation_gain: one-way power gain at an elevation from
    horizontal; None: isotropic; its root counts as positive, so the sign of sidelobes is lost; permittivity: relative, of what
    reflects in place of the sea; heights are those above it.
    """
    geometry = specular_geometry(distance, height, antenna_height, earth_radius)
    ratio = reflected_field_ratio(geometry, wavelength, polarization, wave_height, roughness, permittivity)
    if elevation_gain is None:
        return TwoRays(geometry, np.ones_like(geometry.direct), ratio, np.ones_like(geometry.direct))
    gain = np.maximum(elevation_gain(geometry.elevation_direct), MIN_GAIN)
    weighted = ratio * np.sqrt(elevation_gain(geometry.elevation_reflected) / gain)
    return TwoRays(geometry, gain, weighted, np.ones_like(geometry.direct))


def two_ray_factor(
    distance: Floats | float, height: Floats | float, antenna_height: Floats | float, wavelength: float, **sea: Any
) -> Complexes:
    """Field at each target relative to that of the direct ray alone, F; the amplitude of an echo gets the complex factor F^2.

    Arguments as `two_rays`. F = 1 + Gamma rho_s D exp(-jk (R1 + R2 - R)) R / (R1 + R2) sqrt(G(reflected) / G(direct)): Kerr
    1951, ch. 2, docs/specification.md eq. 12 with corrected sign (docs/specification.md, errata row 5). Beyond the horizon F
    is 0.
    """
    rays = two_rays(distance, height, antenna_height, wavelength, **sea)
    phase = np.exp(-2j * np.pi / wavelength * rays.geometry.excess)
    return np.where(rays.geometry.grazing > 0, 1.0 + rays.ratio * phase, 0.0)


def mean_square_factor(
    ratio: Complexes | Profiles, phase: Floats | Singles, phase_span: Floats | Singles
) -> Floats | Singles:
    """Root of the mean of |F|^4 over a height: the amplitude factor of what stands for a vertical extent.

    ratio: of `TwoRays`; phase: k times the excess in the middle [rad]; phase_span: how far it runs over the extent [rad], evenly.
    With x the phase between both rays |F|^4 = 1 + 4 r^2 + r^4 + 4 r (1 + r^2) cos x + 2 r^2 cos 2x.
    """
    r2, turn, half = ratio.real**2 + ratio.imag**2, turned_back(phase), np.where(phase_span, phase_span / 2.0, 1e-20)
    beat, wave = ratio.real * turn.real - ratio.imag * turn.imag, turned_back(half)  # r cos x; both sincs from one phasor
    once = -wave.imag / half
    mean = 1.0 + 4.0 * r2 + r2 * r2 + 4.0 * (1.0 + r2) * once * beat + 2.0 * once * wave.real * (2.0 * beat * beat - r2)
    return np.asarray(np.sqrt(np.maximum(mean, 0.0)))


def turned_back(phase: Floats | Singles) -> Complexes | Profiles:
    """exp(-j phase), any shape; in a fourth of the time of a complex exponential, a tenth for single precision."""
    turned: Complexes | Profiles = np.empty(np.shape(phase), dtype=np.result_type(phase, np.complex64))
    if turned.dtype == np.complex128:
        KERNELS.phasors(turned.size, np.negative(phase).ravel(), turned.reshape(-1))
        return turned
    np.cos(phase, out=turned.real)
    np.negative(np.sin(phase), out=turned.imag)
    return turned


def printed_two_ray_factor(
    distance: Floats | float,
    height: Floats | float,
    antenna_height: Floats | float,
    wavelength: float,
    *,
    earth_radius: float = np.inf,
    polarization: str = "h",
    wave_height: float = 0.0,
) -> Complexes:
    """F exactly as printed, on a flat earth and without the beam; the specification multiplies the amplitude by |F|^2.

    Arguments as `two_ray_factor`; earth_radius affects D alone. Gamma, rho_s (Ament) and D are computed.
    docs/specification.md eq. 12.
    """
    geometry = specular_geometry(distance, height, antenna_height)
    first, second = geometry.first * np.cos(geometry.grazing), geometry.second * np.cos(geometry.grazing)
    geometry = geometry._replace(divergence=divergence(first, second, geometry.grazing, earth_radius))
    ratio = reflected_field_ratio(geometry, wavelength, polarization, wave_height, ament)
    return np.asarray(1.0 + ratio * np.exp(-2j * np.pi / wavelength * geometry.excess))  # eq. 12


def reflected_field_ratio(
    geometry: SpecularGeometry, wavelength: float, polarization: str, wave_height: Floats | float, roughness: Roughness,
    permittivity: Floats | None = None,
) -> Complexes:  # fmt: skip
    """The reflected field over the direct one, without antenna gains and phase of the path: Gamma rho_s D R / (R1 + R2)."""
    e = sea_water_permittivity(SPEED_OF_LIGHT / wavelength) if permittivity is None else permittivity
    surface = fresnel(geometry.grazing, e, polarization) * roughness(geometry.grazing, wave_height, wavelength)
    spreading = geometry.direct / (geometry.first + geometry.second)
    return surface * geometry.divergence * spreading


def reflection_distance(d: Floats, h: Floats, antenna_height: Floats | float, earth_radius: float) -> Floats:
    """Distance from the antenna to the reflection point [m]: 2x^3 - 3dx^2 + (d^2 - 2ae(h1 + h2))x + 2ae h1 d = 0."""
    flat: Floats = d * antenna_height / (antenna_height + h)
    if np.isinf(earth_radius):
        return flat
    p2 = 4.0 / 3.0 * (earth_radius * (antenna_height + h) + d * d / 4.0)
    p = np.sqrt(p2)  # its cube is p2 p: a power would cost ten times as much
    sine = np.clip(2.0 * earth_radius * d * (h - antenna_height) / (p2 * p), -1.0, 1.0)
    x: Floats = d / 2.0 - p * np.sin(np.arcsin(sine) / 3.0)
    return _between(x, d)


def _between(x: Floats, d: Floats) -> Floats:
    """Distances x, at least 0 and at most d; few of them take half the time of `clip`."""
    return np.asarray(np.minimum(np.maximum(x, 0.0), d))
