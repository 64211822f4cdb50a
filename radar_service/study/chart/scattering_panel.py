"""The third panel: cross-sections of canonical targets on turntables by each scattering model, at random turns."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.sea_paths import Paths, range_and_factor
from radar_service.numerics.frames import polar_from_map
from radar_service.numerics.random import CHART, generator
from radar_service.numerics.types import Floats, Indices
from radar_service.propagation.radar_equation import two_way_phase
from radar_service.radar.patterns import Sinc2
from radar_service.records.fidelity import PRESETS, Fidelity
from radar_service.scattering.model import BodyEchoes, Instant
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.study.chart.canonical_targets import ANTENNA_HEIGHT, DISTANCE, CanonicalTarget, canonical_targets, plates
from radar_service.study.chart.frozen_scene import all_scatterers
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.study.chart.power_panel import mean_and_spread
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.body import Body, Mesh
from radar_service.world.materials import material_from_name
from radar_service.world.motion import Motion
from radar_service.world.poses import BodyPoses, map_from_bodies
from radar_service.world.scene import Scene

STEADY = 20.0  # s before and after an observation in which a target turns at its own rate, a quarter of a scan at most
MAX_RANGE = 2.0 * DISTANCE
BOUNCES = (1, 2, 3)
MODELS = 2 + len(BOUNCES)  # declared, diffuse, optics


def random_turns(targets: Sequence[CanonicalTarget], draws: int, seed: int) -> Floats:
    """Returns random turns (S, T) [rad] of the targets from facing the antenna, one row a draw."""
    limits = np.array([target.max_turn for target in targets])
    return np.asarray(generator(seed, CHART, 2).uniform(-1.0, 1.0, (draws, len(targets))) * limits)


@dataclass(frozen=True)
class Turntables:
    """Targets (T,) that share one scene.

    scene: has the targets, then the screens before them.
    distance: (T,) of the targets [m].
    spokes: (S,) number of the spoke at which each draw is observed.
    passages: the echoes of bodies by aspect as the beam passes; None where they are evaluated at the observation itself.
    """

    scene: Scene
    distance: Floats
    spokes: Indices
    scatterers: ScattererSet
    occlusion: OcclusionScene
    passages: BeamPassages | None

    def cross_sections(self, draw: int) -> Floats:
        """Returns the cross-sections (T,) [m^2] of the targets in a draw."""
        number, time = int(self.spokes[draw]), float(self.spokes[draw]) * self.scene.radar.spoke_period
        echoes = self._at_instant(time) if self.passages is None else self._passing(self.passages, number, time)
        poses = BodyPoses(self.scatterers.bodies).at(np.array([time]))
        position = map_from_bodies(echoes.position, echoes.body, poses.position[0], poses.heading[0])
        return coherent_cross_sections(self.scene, self.distance, position, echoes)

    def _at_instant(self, time: float) -> BodyEchoes:
        return self.scatterers.echoes(self.scene.antenna(time)[0], Instant(time, self.occlusion, MAX_RANGE))

    def _passing(self, passages: BeamPassages, number: int, time: float) -> BodyEchoes:
        """The echoes of a spoke, interpolated between the nodes of the beam's passage."""
        boresight = number % self.scene.radar.azimuths * self.scene.radar.azimuth_step
        azimuths = AzimuthTimes(np.array([number]), np.array([boresight]), np.array([time]))
        observed = passages.echoes(azimuths, boresight, self.scene.radar.beamwidth)
        weights = [1.0 if each.fade is None else each.fade[:, 0] for each in observed]
        parts = zip(observed, weights, strict=True)
        return BodyEchoes.joined([replace(each.echoes, amplitude=each.echoes.amplitude * by) for each, by in parts])


def turntables(
    scene: Scene,
    targets: Sequence[CanonicalTarget],
    turns: Floats,
    scattering: str | None,
    fidelity: Fidelity,
    seed: int,
) -> Turntables:
    """Returns targets (T,) that share one setting, over the sea or not, turning or not, in turns (S, T) [rad].

    scattering: the model of the targets; with None each target declares the cross-section that it has when it faces the antenna
    in free space.
    """
    spokes = _spokes(scene, targets, len(turns), seed)
    turntable = turntable_scene(scene, targets, turns, spokes, scattering)
    scatterers, occlusion = all_scatterers(turntable, fidelity, seed), OcclusionScene(turntable.bodies, np.inf)
    turning = any(target.rate for target in targets) and len(scatterers.aspect_models) > 0
    passages = BeamPassages(turntable, scatterers, occlusion, MAX_RANGE, turntable.radar.beamwidth) if turning else None
    return Turntables(turntable, np.array([target.distance for target in targets]), spokes, scatterers, occlusion, passages)


def _spokes(scene: Scene, targets: Sequence[CanonicalTarget], draws: int, seed: int) -> Indices:
    """Returns the spoke (S,) of each draw, one a scan. Turning targets are observed anywhere within the half-power beam."""
    radar = scene.radar
    half = radar.beamwidth / 2.0 if any(target.rate for target in targets) else 0.0
    aside = generator(seed, CHART, 3).uniform(-half, half, draws)
    crossing = _bearings(targets)[0]
    turns = np.arange(1, draws + 1) + (crossing + aside) / (2.0 * np.pi)
    return np.asarray(np.rint(turns * radar.azimuths), dtype=np.int64)


def _bearings(targets: Sequence[CanonicalTarget]) -> Floats:
    """Returns the bearings (T,) [rad] of targets that share a scene."""
    return np.asarray((np.arange(len(targets)) + 0.5) * (2.0 * np.pi / len(targets)))


def turntable_scene(
    scene: Scene, targets: Sequence[CanonicalTarget], turns: Floats, spokes: Indices, scattering: str | None
) -> Scene:
    """Returns the scene with steel targets about the antenna in place of its bodies, over a flat earth, without a vertical beam.

    turns: (S, T) [rad], held at the spokes (S,). scattering: a model of scene files, None for the declared cross-section.
    """
    over_sea = any(target.over_sea for target in targets)
    height = ANTENNA_HEIGHT if over_sea else scene.radar.height
    radar = replace(scene.radar, height=height, beamwidth_el=np.pi, tilt=0.0, pattern_el=Sinc2())
    antenna = replace(scene, radar=radar).antenna(0.0)[0]
    time = np.asarray(spokes * radar.spoke_period, dtype=np.float64)
    bodies, screens = [], []
    for target, bearing, turn in zip(targets, _bearings(targets), turns.T, strict=True):
        place = antenna + target.distance * np.array([np.sin(bearing), np.cos(bearing), 0.0])
        place[2] = 0.0 if over_sea else antenna[2]
        motion = _turning(time, place, bearing + np.pi + turn, target.rate, radar.rotation_period)
        declared = None if scattering else target.facing
        bodies.append(_body(target.name, target.mesh, motion, scattering or "rcs", declared))
        if target.screen is not None:
            screens.append(_screen(target, antenna, bearing))
    environment = replace(
        scene.environment, earth_factor=np.inf, multipath=over_sea, gas_db_per_km=0.0, rain_mm_h=0.0, sea_state=0
    )
    return replace(scene.with_world(bodies=(*bodies, *screens), environment=environment), radar=radar)


def _turning(time: Floats, place: Floats, heading: Floats, rate: float, period: float) -> Motion:
    """Returns the motion of a target that has a heading (S,) [rad] at each time (S,) [s], and turns at a rate [rad/s] there."""
    steady = min(STEADY, period / 4.0)
    knots = np.stack([time - steady, time + steady], axis=1).ravel()
    headings = np.stack([heading - rate * steady, heading + rate * steady], axis=1).ravel()
    return Motion(knots, np.tile(place, (len(knots), 1)), headings, turning=True)


def _screen(target: CanonicalTarget, antenna: Floats, bearing: float) -> Body:
    """Returns the screen before a target: it occludes, and its own echoes are left out."""
    assert target.screen is not None
    mesh, share, aside = target.screen
    toward, across = np.array([np.sin(bearing), np.cos(bearing), 0.0]), np.array([np.cos(bearing), -np.sin(bearing), 0.0])
    place = antenna + share * target.distance * toward + aside * across
    motion = Motion(np.zeros(1), place[None], np.array([bearing + np.pi]))
    return _body(f"screen of {target.name}", mesh, motion, "rcs", 1.0)


def _body(name: str, mesh: Mesh, motion: Motion, scattering: str, declared: float | None) -> Body:
    size = float(np.ptp(mesh.vertices[:, 0])), float(np.ptp(mesh.vertices[:, 1]))
    return Body(name, mesh, motion, material_from_name("steel", "chart"), scattering, declared, 0, None, *size)


def coherent_cross_sections(scene: Scene, distance: Floats, position: Floats, echoes: BodyEchoes) -> Floats:
    """Returns the cross-sections (T,) [m^2] of the first bodies of a scene, whose echoes add with their phases and paths.

    distance: (T,) of these bodies, at which the cross-sections hold [m]; position: of the echoes (M, 3) on the map [m].
    """
    radar, antenna, count = scene.radar, scene.antenna(0.0)[0], len(distance)
    kept = np.flatnonzero(echoes.body < count)
    position, echoes = position[kept], echoes.chosen(kept)
    polar = polar_from_map(position, antenna, np.inf)
    paths = Paths(echoes.path, echoes.height_span)
    length, factor = range_and_factor(radar, scene.environment, polar, position[:, 2], antenna[2], paths)
    own = distance[echoes.body]
    echo = echoes.amplitude * factor * (own / polar.range) ** 2 * two_way_phase(length - own, radar.wavelength)
    total = np.bincount(echoes.body, echo.real, count) + 1j * np.bincount(echoes.body, echo.imag, count)
    return np.asarray(np.abs(total) ** 2)


@dataclass(frozen=True)
class Model:
    """One scattering model at one setting, prepared for the targets on their turntables."""

    family: str
    setting: str
    tables: tuple[Turntables, ...]
    preset: str | None

    def cross_sections(self, draw: int) -> Floats:
        """Returns the cross-sections (T,) [m^2] of all targets at the turns of a draw."""
        return np.concatenate([table.cross_sections(draw) for table in self.tables])


def all_targets(wavelength: float, polarization: str) -> list[list[CanonicalTarget]]:
    """Returns all targets, those together that share a scene: at rest in free space, over the sea, and turning."""
    each = [*canonical_targets(wavelength), *plates(wavelength, polarization)]
    at_rest = [target for target in each if not target.over_sea and not target.rate]
    return [at_rest, [target for target in each if target.over_sea], [target for target in each if target.rate]]


def scattering_models(scene: Scene, groups: list[list[CanonicalTarget]], turns: Floats, seed: int) -> list[Model]:
    """Returns declared cross-sections, diffuse surfaces, and physical optics with one to three bounces.

    groups: targets that share a scene; turns: (S, T) [rad] of all of them.
    """
    presets: dict[int, list[str]] = {}
    for name, preset in PRESETS.items():
        if preset.engine == "corrected":
            presets.setdefault(preset.bounces, []).append(name)
    columns = np.split(turns, np.cumsum([len(group) for group in groups])[:-1], axis=1)

    def model(family: str, setting: str, scattering: str | None, bounces: int = 1, preset: str | None = None) -> Model:
        fidelity = replace(PRESETS["balanced"], bounces=bounces)
        tables = (
            turntables(scene, *targets_and_turns, scattering, fidelity, seed)
            for targets_and_turns in zip(groups, columns, strict=True)
        )
        return Model(family, setting, tuple(tables), preset)

    optics = [
        model("physical optics", f"{b} bounce{'s' * (b > 1)}", "optics", b, ", ".join(presets.get(b, [])) or None)
        for b in BOUNCES
    ]
    return [model("declared cross-section", "rcs", None), model("diffuse surface", "diffuse", "diffuse"), *optics]


def scattering_points(scene: Scene, draws: int, seed: int, done: Callable[[], object]) -> list[Point]:
    """Returns one point for each scattering model, from `draws` random turns of the targets.

    A model is evaluated once a scan, so each azimuth bears its share of the time. `done` is called after each evaluation.
    """
    groups = all_targets(scene.radar.wavelength, scene.radar.polarization)
    targets = [target for group in groups for target in group]
    turns = random_turns(targets, draws, seed)
    models = scattering_models(scene, groups, turns, seed)
    theory = np.stack([target.cross_section(turns[:, k]) for k, target in enumerate(targets)], axis=1)
    for model in models:
        model.cross_sections(0)  # facets are cut once for a distance; that is not timed
    results: list[list[Floats]] = [[] for _ in models]

    def task(k: int) -> Callable[[], object]:
        return lambda: results[k].append(models[k].cross_sections(len(results[k])))

    times = time_interleaved([task(k) for k in range(len(models))], [draws] * len(models), done)
    azimuths = scene.radar.azimuths
    return [_point(m, t, np.stack(r), theory, azimuths) for m, t, r in zip(models, times, results, strict=True)]


def _point(model: Model, times: Sequence[float], result: Floats, theory: Floats, azimuths: int) -> Point:
    per_azimuth = tuple(t / azimuths for t in times)
    return Point(
        "scattering", model.family, model.setting, per_azimuth, False, *mean_and_spread(result, theory), model.preset
    )
