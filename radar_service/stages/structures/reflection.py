"""What own ship's structures reflect: the way antenna, structure, target, by the aperture's near field and geometrical optics.

A structure is an upright cylinder of radius a at distance d, lit by the tube of waves before the aperture. To a target far off it
reflects as a mirror that is bent in one plane: power falls by a cos(b / 2) / 2 over d, b being the bistatic angle. This is the
scattering width pi a cos(b / 2) of a cylinder in two dimensions (Ruck et al., Radar Cross Section Handbook, 1970, 4.1; Knott,
Shaeffer and Tuley, Radar Cross Section, 2004, ch. 6), over the height of the first Fresnel zone in the third.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from radar_service.echo.beam_paths import Beam, Sights, false_echoes
from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes, concatenated
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Complexes, Flags, Floats
from radar_service.radar.aperture import Aperture, aperture_of
from radar_service.radar.parameters import Radar
from radar_service.stages.structures.structure import Structure, fresnel_integral, fresnel_unit, half_plane
from radar_service.world.scene import Scene

STEPS_PER_UNIT = 50  # of the table of the near field across the beam, in a Fresnel unit
NEAREST, WHOLE = np.radians(15.0), np.radians(30.0)  # from its bearing: nearer, what creeps along it is part of its shadow
# Of the direct field; less reflects nothing: at most -42 dB of a target where the beam is on it too, else -62 dB.
MIN_LIT = 4e-3
BEYOND = 10.0  # Fresnel units beside the aperture that the table covers
SPECULAR = 0.7  # radii from the middle of a structure to its specular point, along the beam, for targets abeam


class Ray(NamedTuple):
    """The ray along the beam to a structure, and on to targets far off (any shape).

    half: cosine of half the bistatic angle.
    detour: one-way length beyond the direct ray's [m].
    across, along: of the specular point, to the right of the middle of the antenna and ahead of it, as the beam points [m].
    """

    half: Floats
    detour: Floats
    across: Floats
    along: Floats


def ray_by(structure: Structure, from_bow: Floats, boresight: Floats) -> Ray:
    """The ray by a structure to targets far off at boresights, both clockwise from the bow, of one shape [rad].

    Its first part runs along the beam, as waves do in the tube before the aperture.
    """
    aside, turned = wrap_angle(from_bow - boresight), structure.bearing - boresight
    half = np.abs(np.sin(aside / 2.0))
    across = structure.distance * np.sin(turned) + np.where(aside < 0.0, -1.0, 1.0) * structure.radius * np.cos(aside / 2.0)
    along = structure.distance * np.cos(turned) - structure.radius * half
    return Ray(half, along * (1.0 - np.cos(aside)) - across * np.sin(aside), across, along)


def near_field(aperture: Aperture, wavelength: float, distance: float, across: Floats) -> Complexes:
    """Field of the aperture `distance` [m] ahead of it, over that on boresight by the far field's law, without the phase ahead.

    across: any shape, to the right of boresight [m]. Beyond D^2 / lambda its size tends to the pattern; near by, on boresight of
    a uniform aperture, its square is lambda d / D^2: the power of a tube as wide as the aperture.
    """
    unit = float(fresnel_unit(wavelength, distance))
    field = np.zeros(np.shape(across), dtype=np.complex128)
    for position, weight in zip(aperture.positions, aperture.weights, strict=True):
        slope = -2.0 * np.pi * position / aperture.length
        shift = slope * unit / np.pi  # by completing the square
        far, near = (fresnel_integral((edge * aperture.length - across) / unit - shift) for edge in (0.5, -0.5))
        field += weight / aperture.length * unit * np.exp(1j * slope * (across + 0.5 * shift * unit)) * (far - near)
    return field


class LitStructure:
    """One structure that an aperture lights."""

    def __init__(self, structure: Structure, aperture: Aperture, wavelength: float, polarization: str) -> None:
        self.structure, self._wavenumber = structure, 2.0 * np.pi / wavelength
        distance = structure.distance - SPECULAR * structure.radius
        unit = float(fresnel_unit(wavelength, distance))
        edge = 0.5 * aperture.length + BEYOND * unit
        self._across = np.linspace(-edge, edge, 2 * int(np.ceil(edge / unit * STEPS_PER_UNIT)) + 1)
        size = structure.reflection * np.sqrt(structure.radius / (2.0 * distance))
        sign = 1.0 if polarization == "h" else -1.0  # metal turns the field along its axis
        below_top = half_plane(structure.top / fresnel_unit(wavelength, distance))
        self._lit = sign * size * below_top * near_field(aperture, wavelength, distance, self._across)
        self.max_field = float(np.abs(self._lit).max())
        bright = np.abs(self._lit) > MIN_LIT
        self._lit[~bright] = 0.0
        sides = float(np.abs(self._across[bright]).max(initial=0.0)) + structure.radius
        self.lit_within = np.pi if sides >= distance else float(np.arcsin(sides / distance))

    def is_lit(self, boresight: Floats) -> Flags:
        """At which boresights (K,) from the bow [rad] the aperture may light the structure."""
        return np.asarray(np.abs(wrap_angle(boresight - self.structure.bearing)) <= self.lit_within)

    def field(self, from_bow: Floats, boresight: Floats) -> tuple[Complexes, Ray]:
        """One-way field to targets (E, K) at boresights (K,), over the direct ray's on boresight, and its ray; angles are from
        the bow [rad]. Its phase is that of the detour. There is none to targets within NEAREST of the structure's bearing."""
        ray = ray_by(self.structure, from_bow, boresight)
        lit = np.interp(ray.across, self._across, self._lit, left=0.0, right=0.0)
        aside = np.abs(wrap_angle(from_bow - self.structure.bearing))
        lit *= np.sin(0.5 * np.pi * np.clip((aside - NEAREST) / (WHOLE - NEAREST), 0.0, 1.0)) ** 2
        lit *= ray.along > 0.0
        return lit * np.sqrt(ray.half) * np.exp(-1j * self._wavenumber * ray.detour), ray


@lru_cache(maxsize=8)
def reflectors(
    aperture: Aperture, wavelength: float, structures: tuple[Structure, ...], polarization: str
) -> tuple[LitStructure, ...]:
    """The structures that reflect."""
    return tuple(LitStructure(each, aperture, wavelength, polarization) for each in structures if each.reflection > 0.0)


def structure_reflectors(radar: Radar) -> tuple[LitStructure, ...]:
    """The structures of a radar's ship that reflect."""
    structures = radar.effects.get("structures", ())
    aperture = aperture_of(radar.pattern, radar.beamwidth, radar.wavelength) if structures else None
    return () if aperture is None else reflectors(aperture, radar.wavelength, structures, radar.polarization)


class IndirectPaths:
    """Paths by own ship's structures: there and back by one, and one way by it. Their echoes are false.

    They stand where boresight points at the structure, farther off than the target by the detour or by half of it. A target has
    the echoes that the antenna receives of it: from a structure some metres off, scatterers add up with other phases.
    """

    def __init__(self, radar: Radar, beam: Beam, source: int) -> None:
        """source: as of `false_echoes`."""
        self._radar, self._beam, self._source, self._reflectors = radar, beam, source, structure_reflectors(radar)

    def are_lit(self, scene: Scene, azimuths: AzimuthTimes) -> Flags:
        """At which azimuths (K,) any structure may be lit."""
        boresight = azimuths.boresight - scene.platform.heading(azimuths.time)
        return np.asarray(np.any([reflector.is_lit(boresight) for reflector in self._reflectors], axis=0))

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The false echoes of all structures."""
        direct = self._beam.field(sights)
        parts = [part for reflector in self._reflectors for part in self._by(reflector, echoes, sights, direct)]
        return concatenated(parts, len(sights.boresight))

    def _by(
        self, reflector: LitStructure, echoes: BeamWeightedEchoes, sights: Sights, direct: Complexes
    ) -> list[BeamWeightedEchoes]:
        """Paths there and back by one structure, and paths one way by it."""
        field, ray = reflector.field(sights.from_bow, sights.boresight - sights.heading)
        return [
            false_echoes(self._radar, echoes, field**2, ray.detour, self._source),
            false_echoes(self._radar, echoes, 2.0 * direct * field, 0.5 * ray.detour, self._source),
        ]
