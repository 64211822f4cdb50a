"""The fourth panel: powers of a scene's ships in a seaway, where aspects share a trace of shadows and tubes and where not."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.sea_paths import Paths, range_and_factor
from radar_service.echo.second_time_around import max_echo_range
from radar_service.numerics.frames import effective_earth_radius, polar_from_map
from radar_service.numerics.types import Complexes, Floats
from radar_service.propagation.radar_equation import two_way_phase
from radar_service.records.fidelity import PRESETS, Fidelity
from radar_service.scattering.model import ScatteringContext
from radar_service.scattering.physical_optics.facets import EdgeLimits
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.scattering.physical_optics.optical_body import optical_bodies
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.body import Body
from radar_service.world.scene import Scene
from radar_service.world.sway import Sway

SHIPS = 3  # of a scene, those with the most triangles
ROLL, PITCH, PERIOD = math.radians(5.0), math.radians(1.0), 10.0  # rad and s, in which each ship rolls and pitches
STEPS_DEG = (0.05, 0.1, 0.2, 0.4)  # that traces hold for
BOUNCES = (1, 2, 3)
METHODS = len(BOUNCES) + len(STEPS_DEG) + 1  # with the finer one
TRACED, SHARED = "each aspect traced", "aspects share a trace"
SMALLER = 0.5  # of the longest edge of facets and tubes: against these the others err


@dataclass(frozen=True)
class RollingShip:
    """A ship alone on the sea by one method. passages: of the beam over her."""

    scene: Scene
    passages: BeamPassages

    @classmethod
    def of(cls, scene: Scene, fidelity: Fidelity, finer: float = 1.0) -> "RollingShip":
        """The only ship of a scene; finer: times the longest edge of facets and tubes."""
        earth_radius = effective_earth_radius(scene.environment.earth_factor)
        context = ScatteringContext(
            scene.radar, fidelity, 0, scene.antenna(0.0)[0], scene.environment, scene.bodies, earth_radius
        )
        (optical,) = optical_bodies(scene.bodies, scene.radar, fidelity.bounces)
        range_cell, beamwidth, wavelength, extent = optical.limits
        limits = EdgeLimits(finer * range_cell, finer * beamwidth, finer**2 * wavelength, finer * extent)
        key = np.zeros(1, dtype=np.int64)
        model = PhysicalOptics(scene.bodies, key, [replace(optical, limits=limits)], context)
        scatterers = ScattererSet(scene.bodies, key, (model,))
        occlusion, reach = OcclusionScene(scene.bodies, earth_radius), fidelity.beam_extent * scene.radar.beamwidth
        return cls(scene, BeamPassages(scene, scatterers, occlusion, max_echo_range(scene.radar), reach))

    def nodes(self, scan: int) -> tuple[int, list[int]]:
        """The spoke of the crossing in a scan, and those (K) at which she is evaluated."""
        radar, (body,) = self.scene.radar, self.scene.bodies
        offset = body.middle_at(scan * radar.rotation_period) - self.scene.antenna(scan * radar.rotation_period)[0]
        crossing = self.passages.crossing(0, scan + float(np.arctan2(offset[0], offset[1])) / (2.0 * np.pi) % 1.0)
        return crossing, self.passages.nodes(0, crossing).tolist()

    def powers(self, crossing: int, nodes: Sequence[int]) -> Floats:
        """A ship's powers (K,) at spokes (K,) about a crossing: its fields in cells of range, squared and summed."""
        runs, times = self.passages.runs(0, crossing), [self.scene.radar.time_of_spokes(float(node)) for node in nodes]
        observed = [self.passages.evaluated(0, node, t, runs.get(node)) for node, t in zip(nodes, times, strict=True)]
        return np.array([np.sum(np.abs(self._field(echoes, t)) ** 2) for echoes, t in zip(observed, times, strict=True)])

    def _field(self, observed: ObservedEchoes, time: float) -> Complexes:
        """Sums of echoes in cells of range (N,), as far as she reaches."""
        radar, environment, antenna = self.scene.radar, self.scene.environment, self.scene.antenna(time)[0]
        polar = polar_from_map(observed.position, antenna, effective_earth_radius(environment.earth_factor))
        paths = Paths(observed.echoes.path, observed.echoes.height_span)
        height = observed.position[:, 2]
        length, factor = range_and_factor(radar, environment, polar, height, np.full(len(height), antenna[2]), paths)
        echo = observed.echoes.amplitude * factor * two_way_phase(length, radar.wavelength)
        cell = np.floor(polar.range / radar.range_resolution).astype(np.int64)
        count = int(max_echo_range(radar) / radar.range_resolution) + 1
        return np.bincount(cell, echo.real, count) + 1j * np.bincount(cell, echo.imag, count)


def rolling_ships(scene: Scene) -> list[Scene]:
    """Each of the ships of a scene alone, metal under way by physical optics, rolling and pitching; the largest meshes first."""
    sway = Sway(np.array([ROLL, PITCH, 0.0, 0.0]), np.full(4, PERIOD))
    ships = [body for body in scene.bodies if body.scattering == "optics" and body.mesh is not None and body.top_speed > 0.0]
    ships.sort(key=lambda body: -_triangles(body))
    return [
        scene.with_world(bodies=(replace(body, motion=replace(body.motion, sway=sway), swerling=0),))
        for body in ships[:SHIPS]
    ]


def _triangles(body: Body) -> int:
    return 0 if body.mesh is None else len(body.mesh.faces)


def ships_points(ships: Sequence[Scene], scans: int, done: Callable[[], object]) -> list[Point]:
    """One point for each method, from passages of the beam over each ship, in scans that follow one another; none where no ship
    has an echo, as beyond the range or the horizon.

    An azimuth bears its share of the time of a scan. `done` is called after each scan of a method.
    """
    balanced = PRESETS["balanced"]
    settings = [(TRACED, f"{b} bounce{'s' * (b > 1)}", replace(balanced, bounces=b, trace_step_deg=0.0)) for b in BOUNCES]
    settings += [(SHARED, f"{step:g} degrees", replace(balanced, trace_step_deg=step)) for step in STEPS_DEG]
    exact = [RollingShip.of(ship, replace(balanced, trace_step_deg=0.0), SMALLER) for ship in ships]
    exact = [ship for ship in exact if ship.powers(*ship.nodes(0)).any()]
    if not exact:
        return []
    methods = [[RollingShip.of(ship.scene, fidelity) for ship in exact] for *_, fidelity in settings] + [exact]
    passages = [[ship.nodes(scan) for ship in methods[0]] for scan in range(scans + 1)]
    results: list[list[list[Floats]]] = [[] for _ in methods]

    def observed(k: int, scan: int) -> list[Floats]:
        return [ship.powers(*passage) for ship, passage in zip(methods[k], passages[scan], strict=True)]

    def task(k: int) -> Callable[[], object]:
        return lambda: results[k].append(observed(k, len(results[k]) + 1))

    for k in range(len(methods)):
        observed(k, 0)  # facets are cut once for a distance; that is not timed
    times = time_interleaved([task(k) for k in range(len(methods))], [scans] * len(methods), done)
    azimuths = ships[0].radar.azimuths
    return [
        Point(
            "ships",
            family,
            setting,
            tuple(t / azimuths for t in taken),
            False,
            *power_errors(powers, results[-1]),
            None,
            _preset(f),
        )
        for (family, setting, f), taken, powers in zip(settings, times, results, strict=False)
    ]


def _preset(fidelity: Fidelity) -> str | None:
    """The presets that treat ships like this."""
    same = [
        name
        for name, preset in PRESETS.items()
        if preset.engine == "corrected"
        and (preset.bounces, preset.trace_step_deg) == (fidelity.bounces, fidelity.trace_step_deg)
    ]
    return ", ".join(same) or None


def power_errors(result: Sequence[Sequence[Floats]], exact: Sequence[Sequence[Floats]]) -> tuple[float, float]:
    """Error of the mean power and spread of one aspect's [dB], rms over ships, of powers by scan, ship and aspect."""
    mean, spread = [], []
    for ship in range(len(exact[0])):
        powers, truth = (np.concatenate([scan[ship] for scan in scans]) for scans in (result, exact))
        mean.append(10.0 * np.log10(powers.mean() / truth.mean()))
        spread.append(10.0 * np.log10(1.0 + (powers - truth).std() / truth.mean()))
    return float(np.sqrt(np.mean(np.square(mean)))), float(np.sqrt(np.mean(np.square(spread))))
