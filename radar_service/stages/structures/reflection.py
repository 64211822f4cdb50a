"""What own ship's structures reflect: the way antenna, structure, target, by the aperture's near field and geometrical optics.

A structure is an upright cylinder of radius a at distance d, lit by the tube of waves before the aperture. To a target far off it
reflects as a mirror that is bent in one plane: power falls by a cos(b / 2) / 2 over d, b being the bistatic angle. This is the
scattering width pi a cos(b / 2) of a cylinder in two dimensions (Ruck et al., Radar Cross Section Handbook, 1970, 4.1; Knott,
Shaeffer and Tuley, Radar Cross Section, 2004, ch. 6), over the height of the first Fresnel zone in the third.

Indirect echoes are weak, and a structure is some metres off the antenna: they take the aspect that the direct echo has at its
crossing. Its centres, by the sea too, are summed with their phases in cells of range and bearing, with exact ranges.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from radar_service.echo import (
    AzimuthTimes,
    Beam,
    BeamPassages,
    BeamWeightedEchoes,
    ObservedEchoes,
    Sights,
    Visibility,
    concatenated,
    false_echoes,
)
from radar_service.numerics import Complexes, Flags, Floats, ResultCache, effective_earth_radius, polar_from_map, wrap_angle
from radar_service.propagation import LandBefore, radar_two_rays, two_way_phase
from radar_service.radar import Aperture, Radar, aperture_of
from radar_service.scattering import DIRECT, BodyEchoes
from radar_service.stages.structures.structure import Structure, fresnel_integral, fresnel_unit, half_plane
from radar_service.trace import OcclusionScene
from radar_service.world import Scene

STEPS_PER_UNIT = 50  # of the table of the near field across the beam, in a Fresnel unit
NEAREST, WHOLE = np.radians(15.0), np.radians(30.0)  # from its bearing: nearer, what creeps along it is part of its shadow
# Of the direct field; less reflects nothing: at most -42 dB of a target where the beam is on it too, else -62 dB.
MIN_LIT = 4e-3
BEYOND = 10.0  # Fresnel units beside the aperture that the table covers
SPECULAR = 0.7  # radii from the middle of a structure to its specular point, along the beam, for targets abeam
CELLS_PER_RANGE = 2.0  # in a range resolution: centres move by a quarter of one at most
CELLS_PER_BEAM = 4.0  # in a beamwidth, at least: sidelobes, half as wide as the main lobe, are followed
CELL_PHASE = 1.0  # rad at most by which the way by the farthest structure differs in a cell
PASSAGES_PER_BODY = 4  # kept: those in use, and those of threads that are ahead
TINY = 1e-30  # m^2


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
def structure_reflectors(radar: Radar) -> tuple[LitStructure, ...]:
    """The structures of a radar's ship that reflect."""
    reflecting = [each for each in radar.effects.get("structures", ()) if each.reflection > 0.0]
    aperture = aperture_of(radar.pattern, radar.beamwidth, radar.wavelength) if reflecting else None
    if aperture is None:
        return ()
    return tuple(LitStructure(each, aperture, radar.wavelength, radar.polarization) for each in reflecting)


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
        direct, parts = self._beam.field(sights), []
        for reflector in self._reflectors:
            field, ray = reflector.field(sights.from_bow, sights.boresight - sights.heading)
            for path, farther in ((field**2, ray.detour), (2.0 * direct * field, 0.5 * ray.detour)):
                parts.append(false_echoes(self._radar, echoes, path, farther, self._source))
        return concatenated(parts, len(sights.boresight))


class HeldPassages(BeamPassages):
    """All bodies of a set, each with one aspect for all azimuths about a crossing. Safe to call from several threads."""

    def __init__(self, scene: Scene, visibility: Visibility, direct: BeamPassages) -> None:
        """direct: passages of the same bodies, but for those at rest, as their direct echoes have them."""
        super().__init__(scene, visibility.scatterers, visibility.line_of_sight, visibility.max_range, np.pi)
        self._direct = direct
        self._in_direct = {int(key): number for number, key in enumerate(direct.key.tolist())}
        count = PASSAGES_PER_BODY * max(1, len(self))
        self._held: ResultCache[tuple[int, int, bytes], ObservedEchoes] = ResultCache(count, scene.revision)
        self._resting: ResultCache[int, ObservedEchoes] = ResultCache(max(1, len(self)))

    def echoes(self, azimuths: AzimuthTimes, middle: float, half: float) -> list[ObservedEchoes]:
        time = azimuths.middle
        present = self._line_of_sight.present(time)[self.key]
        parts = [self.held(n, crossing, time) for n, crossing in self.passing(time, middle, half) if present[n]]
        return ObservedEchoes.joined(parts)

    def held(self, n: int, crossing: int, time: float) -> ObservedEchoes:
        """The echoes of body n for all azimuths about a crossing; those bodies occlude that are present at `time` [s]."""
        key, time = self._passage(n, crossing, time)
        return self._held.get(key, lambda: self._computed(n, crossing, time))

    def _computed(self, n: int, crossing: int, time: float) -> ObservedEchoes:
        number = self._in_direct.get(int(self.key[n]))
        if number is None and self._casters(n, crossing, self._half_angle(n, crossing), resting=True):
            return self._cells(n, self.evaluated(n, crossing, time), crossing)
        if number is None:
            return self._resting.get(n, lambda: self._cells(n, self._unshaded(n, crossing, time), crossing))
        nodes = self._direct.nodes(number, crossing, time)
        node = int(nodes[np.abs(nodes - crossing).argmin()])
        return self._cells(n, self._direct.node(number, node, time), node)

    def _unshaded(self, n: int, crossing: int, time: float) -> ObservedEchoes:
        """The echoes of body n, which rests as the antenna does, without shadows of moving bodies."""
        model, local, body = self._aspects[n]
        antenna, instant = self._observed(crossing, time)
        echoes = model.body_echoes(local, antenna, replace(instant, movers=False))
        (position,) = self._placed(n, [echoes], instant.time)
        return ObservedEchoes(replace(echoes, body=np.full(len(echoes), body)), position)

    def _cells(self, n: int, observed: ObservedEchoes, node: int) -> ObservedEchoes:
        """Echoes of body n as it is at a node, summed in cells."""
        antenna = self._scene.antenna(self._scene.radar.time_of_spokes(float(node)))[0]
        return in_cells(observed, self._aspects[n].body, antenna, self._scene, self._line_of_sight)


def in_cells(
    observed: ObservedEchoes, body: int, antenna: Floats, scene: Scene, line_of_sight: OcclusionScene
) -> ObservedEchoes:
    """Echoes of one body, with its index, summed in cells of range and bearing: each at the middle of their power, with the field
    of all together for the antenna (3,) [m], by the sea too. line_of_sight: past all bodies."""
    echoes, radar, earth_radius = observed.echoes, scene.radar, effective_earth_radius(scene.environment.earth_factor)
    if not len(echoes):
        return replace(observed, echoes=replace(echoes, body=np.full(0, body)))
    polar = polar_from_map(observed.position, antenna, earth_radius)
    farthest = max(structure.distance for structure in radar.effects["structures"])
    widest = min(radar.beamwidth / CELLS_PER_BEAM, CELL_PHASE * radar.wavelength / (2.0 * np.pi * farthest))
    steps = radar.range_resolution / CELLS_PER_RANGE, widest
    aside, path = wrap_angle(polar.azimuth - polar.azimuth[0]), np.minimum(echoes.path, DIRECT)
    cells = np.stack([np.floor(polar.range / steps[0]), np.floor(aside / steps[1]), path.astype(np.float64)])
    _, first, cell = np.unique(cells, axis=1, return_index=True, return_inverse=True)
    cell = cell.ravel()
    power = np.abs(echoes.amplitude) ** 2 + TINY
    total = np.bincount(cell, power)

    def middle(values: Floats) -> Floats:
        return np.stack([np.bincount(cell, power * column) / total for column in values.T], axis=-1)

    position = middle(observed.position)
    farther = polar.range - polar_from_map(position, antenna, earth_radius).range[cell]
    amplitude = echoes.amplitude
    by_sea = np.flatnonzero(echoes.path > DIRECT)
    if len(by_sea):
        place, way = observed.position[by_sea, 2], echoes.path[by_sea]
        land = LandBefore(line_of_sight, antenna, observed.position[by_sea] - antenna)
        rays = radar_two_rays(radar, scene.environment, polar.distance[by_sea], place, float(antenna[2]), land=land)
        amplitude = amplitude.copy()
        amplitude[by_sea] *= rays.ratio**way
        farther[by_sea] += way / 2.0 * rays.geometry.excess
    turned = amplitude * two_way_phase(farther, radar.wavelength)
    summed = np.bincount(cell, turned.real) + 1j * np.bincount(cell, turned.imag)
    which, height = np.full(len(first), body), middle(echoes.height_span[:, None])[:, 0]
    return ObservedEchoes(BodyEchoes(middle(echoes.position), summed, which, path[first], height), position)
