"""Sets up what computes the scans of a simulator, with what is requested of sources: labels, powers, radiometric truth."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from radar_service.engine.documented import DocumentedEngine
from radar_service.engine.preparation import Prepared, prepare
from radar_service.engine.stitched import near_seed, pulse_scenes
from radar_service.numerics import BLAS_LIMIT, Flags, Profiles, Singles, effective_earth_radius
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.cost_model import EngineStatistics, SetUp, engine_statistics, first_visibility_update
from radar_service.plan.culling import cull
from radar_service.plan.plan import Plan, plan_for
from radar_service.plan.settings_search import fidelity_for
from radar_service.records import Crossing, Fidelity, Labels, Powers, PowersOf, SourceList, SourceRequest, fidelity_from_name
from radar_service.sources.labels import LabellingEngine, LabellingStitchedEngine
from radar_service.sources.numbers import source_names, source_numbers
from radar_service.sources.power_window import PulsePowers, ScanPowers, pulse_powers, scan_powers
from radar_service.sources.radiometric import RadiometricTruth
from radar_service.trace import OcclusionScene, RayCount
from radar_service.world import Scene, Steering

DOCUMENTED = "the fidelity 'documented' has none; choose another fidelity"


def check_arguments(scene: Any, seed: int, threads: int, sector: tuple[float, float] | None) -> None:
    """Raises TypeError for what is no Scene, and ValueError for other arguments that a simulator cannot have."""
    if not isinstance(scene, Scene):
        raise TypeError(f"scene: {scene!r:.60} is no Scene; load it first: Simulator(load_scene({scene!r:.60}))")
    if not 0 <= seed < 2**64:
        raise ValueError(f"seed: {seed} is not allowed; a whole number from 0 to 2**64 - 1")
    if threads < 1:
        raise ValueError(f"threads: {threads} is not allowed; 1 or more, best as many as there are cores to spare")
    if sector is not None and (len(sector) != 2 or not np.isfinite(sector).all()):
        raise ValueError(f"sector: {sector} is not allowed; two angles [rad] clockwise from north, as (0.0, 0.3)")


AzimuthEngine = LabellingEngine | LabellingStitchedEngine | DocumentedEngine  # the pipeline, or the specification as printed


class EngineSetUp(NamedTuple):
    """What a simulator computes with.

    engine: computes tiles.
    set_up: of the pipeline, for the last pulse of the radar; None: the specification as printed has no plan of its own.
    line_of_sight: all that may occlude.
    pulses: the scene prepared for each pulse, by rising range; none for the specification as printed.
    """

    engine: AzimuthEngine
    set_up: SetUp | None
    line_of_sight: OcclusionScene
    pulses: tuple[Prepared, ...] = ()

    def plan(self, scene: Scene, fidelity: Fidelity, *, measured: bool = True) -> Plan:
        """Returns the plan of its scene. measured: with counts and costs, which take a second to measure."""
        if self.set_up is None:
            return plan_for(scene, fidelity)
        return plan_for(
            scene, fidelity, engine_statistics(self.set_up) if measured else EngineStatistics(self.set_up.culled)
        )


@BLAS_LIMIT.held()
def engine_set_up(scene: Scene, fidelity: Fidelity, requested: str | Fidelity, seed: int) -> EngineSetUp:
    """Returns the engine of a scene: a LabelledEngine but for the specification as printed.

    fidelity: `chosen_fidelity` of the requested one; other pulses of the radar choose theirs.
    """
    if fidelity.engine == "documented":
        line_of_sight = OcclusionScene(
            scene.bodies, effective_earth_radius(scene.environment.earth_factor), revision=scene.revision
        )
        return EngineSetUp(DocumentedEngine(scene, fidelity, seed), None, line_of_sight)
    set_up = pipeline_set_up(scene, fidelity, seed)
    pulses = prepared_pulses(scene, set_up.prepared, requested, seed)
    engines = [LabellingEngine(prepared) for prepared in pulses]
    engine = LabellingStitchedEngine(engines) if len(engines) > 1 else engines[0]
    return EngineSetUp(engine, set_up, set_up.prepared.line_of_sight, pulses)


def prepared_pulses(scene: Scene, last: Prepared, requested: str | Fidelity, seed: int) -> tuple[Prepared, ...]:
    """Returns a scene prepared for each pulse of its radar, by rising range; last: for the last one."""
    near = [(part, chosen_fidelity(part, requested), seed, near_seed(seed, k)) for k, part in enumerate(pulse_scenes(scene))]
    return (*(pipeline_set_up(*made_from).prepared for made_from in near), last)


def chosen_fidelity(scene: Scene, fidelity: str | Fidelity) -> Fidelity:
    """Returns the requested fidelity for a scene. Raises ValueError for an unknown name."""
    if fidelity == "auto":
        return fidelity_for(scene, ErrorBudget())
    return fidelity_from_name(fidelity) if isinstance(fidelity, str) else fidelity


@BLAS_LIMIT.held()
def pipeline_set_up(scene: Scene, fidelity: Fidelity, seed: int, noise_seed: int | None = None) -> SetUp:
    """Culls what the scene does not need, prepares the pipeline and runs the first visibility update.

    noise_seed: of what a near pulse has of its own.
    """
    rays = RayCount()
    culled = cull(scene, fidelity)
    transparent = [key for key, body in culled.items() if not body.occludes]
    prepared = prepare(scene, fidelity, seed, culled, transparent, rays, noise_seed)
    set_up_rays = rays.rays
    first_visibility_update(prepared)
    return SetUp(prepared, culled, set_up_rays, rays.rays - set_up_rays)


class SourceTile(NamedTuple):
    """Some azimuths (K,) of a scan from `start` on: field [sqrt(W)] and power [W] (K, N), and what is requested of sources.

    An engine yields its first fields, as many as it computes.
    """

    start: int
    field: Profiles
    power: Singles
    labels: Labels | None = None
    powers: Powers | None = None


class SourceTiles:
    """The tiles of an engine. Powers are computed anew.

    request: what they tell of sources; it may change between scans.
    length: azimuths in a tile; 0 for the specification as printed.
    """

    def __init__(self, engine: AzimuthEngine, pulses: Sequence[Prepared], request: SourceRequest) -> None:
        """pulses: the scene prepared for each, as of EngineSetUp; the specification as printed has none, and no sources."""
        self.engine, self.request = engine, request
        self._pulses = pulses
        self.length = pulses[-1].tile if pulses else 0

    @cached_property
    def _powers(self) -> list[PulsePowers]:
        return pulse_powers(self._pulses, source_numbers(self._pulses[-1].scene))

    def sources(self, scene: Scene) -> SourceList:
        """Returns what spokes can tell of the sources of a scene."""
        reason = "" if self._pulses else DOCUMENTED
        return SourceList(source_names(scene), reason, reason)

    def scan(self, scan: int, requested: Flags | None) -> Iterator[tuple[Any, ...]]:
        """Returns the tiles of a scan, each as the first fields of a SourceTile; only those that hold any of the requested
        azimuths (A,), where there are flags of these."""
        tiles: Iterator[tuple[Any, ...]]
        if self.request.labels and not isinstance(self.engine, DocumentedEngine):
            tiles = self.engine.labelled_tiles(scan, requested)
        else:
            tiles = self.engine.tiles(scan, requested)
        return self._with_powers(tiles, scan, self.request.powers) if self.request.powers else tiles

    def _with_powers(self, tiles: Iterator[tuple[Any, ...]], scan: int, requested: PowersOf) -> Iterator[SourceTile]:
        powers = ScanPowers(self._powers, scan, requested)
        for tile in (SourceTile(*fields) for fields in tiles):
            yield tile._replace(powers=powers.between(tile.start, tile.start + len(tile.field)))


class SourceTruth:
    """Computes azimuths again, source by source. Safe to call from several threads.

    A steered run is computed from its past: a second preparation, whose bodies move as they were commanded at each time.
    """

    def __init__(
        self, steering: Steering, fidelity: Fidelity, requested: str | Fidelity, seed: int, pulses: tuple[Prepared, ...]
    ) -> None:
        """fidelity: of the requested one; pulses: those of the run; none for the fidelity `documented`, which has no sources."""
        self._steering, self._fidelity, self._requested, self._seed = steering, fidelity, requested, seed
        self._pulses = pulses
        self._past: tuple[Prepared, ...] = ()
        self._radiometric: RadiometricTruth | None = None
        self._followed = 0  # commands that both know
        self._lock = Lock()

    def powers(self, scan: int) -> dict[int, Singles]:
        """Returns what Simulator.source_powers returns. Raises ValueError for the fidelity `documented`."""
        with self._lock:
            pulses = self._prepared("source_powers")
            return scan_powers(pulse_powers(pulses, source_numbers(self._steering.scene)), scan)

    def measured(self, crossings: tuple[Crossing, ...]) -> tuple[Crossing, ...]:
        """Returns crossings with their radiometric part. Raises ValueError for the fidelity `documented`."""
        index = {body.name: k for k, body in enumerate(self._steering.scene.bodies)}
        with self._lock:
            pulses = self._prepared("radiometric")
            if self._radiometric is None:
                self._radiometric = RadiometricTruth(pulses)
            return tuple(
                replace(crossing, **vars(self._radiometric.at(index[crossing.body], crossing.spoke)))
                for crossing in crossings
            )

    def _prepared(self, name: str) -> tuple[Prepared, ...]:
        """What to compute from, for each pulse. name: of the argument or method that needs it."""
        if not self._pulses:
            raise ValueError(f"{name}: the fidelity 'documented' has none; choose another fidelity")
        past = self._steering.past
        if past is self._steering.scene:
            return self._pulses
        if not self._past:
            last = pipeline_set_up(past, self._fidelity, self._seed).prepared
            self._past = prepared_pulses(past, last, self._requested, self._seed)
        if self._followed != self._steering.count:
            self._radiometric, self._followed = None, self._steering.count
        return self._past
