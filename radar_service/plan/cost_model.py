"""Counts and costs of a prepared engine: echoes, rays and transforms, and CPU times of its stages on this machine.

Counts come from the engine's own records and formulas. No choice depends on costs, except where the user limits time.

Costs are CPU times of tiles of the second scan, in order: of all where a scan takes less than MAX_SECONDS, otherwise of stretches
spread evenly over it. A tile before each stretch fills the caches. Visibility updates are counted apart: a tile has few or none.
"""

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from radar_service.echo import Visibility
from radar_service.engine.pipeline import (
    add_resting,
    add_stages,
    blocks,
    land_spectra,
    moving_rows,
    receive,
    tile_azimuths,
    visibility_steps,
)
from radar_service.engine.preparation import Prepared
from radar_service.numerics import Indices
from radar_service.plan.culling import CulledBody
from radar_service.records import square_law
from radar_service.stages.stage import Tile
from radar_service.world import Scene

MAX_SECONDS = 1.0  # CPU time after which no further stretch is timed
STRETCHES = 16  # that make a scan
MIN_TILES = 4  # timed even where they take longer
SCAN = 1  # the first scan has costs that occur once
MICROSECONDS = 1e6  # per second


@dataclass(frozen=True)
class Counts:
    """Counts of what the engine computes.

    resting_echoes: echoes of bodies at rest, computed once.
    moving_echoes: echoes of moving bodies in the first visibility update.
    shadowed_echoes: resting echoes that moving bodies occlude in the first visibility update.
    scatterers: fixed scatterers of all modelled bodies.
    set_up_rays: rays cast once, by preparation.
    look_rays: rays cast by the first visibility update.
    looks_per_scan: visibility updates per scan.
    transform_samples: samples of all Fourier transforms of one profile with moving echoes.
    """

    resting_echoes: int
    moving_echoes: int
    shadowed_echoes: int
    scatterers: int
    set_up_rays: int
    look_rays: int
    looks_per_scan: float
    transform_samples: int


@dataclass(frozen=True)
class Costs:
    """CPU time of one thread per azimuth [us], on average over a scan.

    looks: visibility updates.
    moving: moving echoes and their gridding.
    receiver: Fourier transforms and noise.
    profiles: schedule, resting profiles, detection and hand-over.
    aspects: physical optics as the beam passes; the gridding of its echoes is in `moving`.
    effects: of the effects of `stages`, by their names.
    """

    looks: float
    moving: float
    receiver: float
    profiles: float
    aspects: float = 0.0
    effects: Mapping[str, float] = field(default_factory=dict)

    @property
    def total(self) -> float:
        """The sum of all stages [us]."""
        return sum(self.by_stage().values())

    def by_stage(self) -> dict[str, float]:
        """All costs [us] by their names."""
        costs = asdict(self)
        return {**costs.pop("effects"), **costs}


@dataclass(frozen=True)
class PerBody:
    """Scatterers and echoes of each body (B,) of the scene.

    Echoes of moving bodies are those in all directions in the first visibility step.
    """

    scatterers: Indices
    echoes: Indices


@dataclass(frozen=True)
class EngineStatistics:
    """What is known of a scene.

    culled: bodies that are not modelled, by index.
    counts, bodies, costs: of the engine; None before it is prepared, and for `documented`.
    land_border: distance [m] from which on land under way is evaluated once a passage at the start; None where none is.
    """

    culled: Mapping[int, CulledBody] = field(default_factory=dict)
    counts: Counts | None = None
    bodies: PerBody | None = None
    costs: Costs | None = None
    land_border: float | None = None


def realtime_factor(scene: Scene, costs: Costs) -> float:
    """Simulated seconds per second of one thread."""
    return scene.radar.spoke_period / (costs.total * 1e-6) if costs.total > 0.0 else math.inf


@dataclass(frozen=True)
class SetUp:
    """A prepared engine.

    prepared: the engine.
    culled: bodies that were culled before, by index.
    set_up_rays: rays cast by preparation.
    look_rays: rays cast by the first visibility update.
    """

    prepared: Prepared
    culled: Mapping[int, CulledBody]
    set_up_rays: int
    look_rays: int


def first_visibility_update(prepared: Prepared) -> int:
    """Runs the first visibility update and returns the number of its moving echoes; the result is cached.

    Bodies by physical optics, and land on the grid, are evaluated as far as the beam passes them in the first tile.
    """
    first = tile_azimuths(prepared, 0, 0)
    passing = prepared.moving.passing(first)
    land = 0 if prepared.land is None else prepared.land.echoes_about(first)
    prepared.shadows.at(0)
    visible = len(prepared.moving.snapshot(0).echoes)
    return visible + sum(len(observed.echoes) for observed in passing) + land


def engine_statistics(set_up: SetUp) -> EngineStatistics:
    """Counts and costs of an engine. Costs are measured now, which takes about a second."""
    prepared = set_up.prepared
    land = None if prepared.land is None else prepared.land.passages
    border = None if land is None else land.border(land.way_at(0.0))
    return EngineStatistics(set_up.culled, engine_counts(set_up), counts_per_body(prepared), timed_costs(prepared), border)


def engine_counts(set_up: SetUp) -> Counts:
    """Counts of what the engine computes."""
    prepared = set_up.prepared
    visible, shadows = first_visibility_update(prepared), prepared.shadows.at(0)
    radar, scattered = prepared.scene.radar, [prepared.resting_set, *(part.scatterers for part in _visibilities(prepared))]
    return Counts(
        len(prepared.resting),
        visible,
        len(shadows.range),
        int(sum(scatterers.scatterers.sum() for scatterers in scattered)),
        set_up.set_up_rays,
        set_up.look_rays,
        radar.rotation_period / prepared.moving.visibility.interval,
        prepared.compression.transformed(
            any(map(len, scattered[1:])) or len(shadows.range) > 0, prepared.scene.environment.noise
        ),
    )


def counts_per_body(prepared: Prepared) -> PerBody:
    """Scatterers and echoes of each body."""
    scatterers, echoes = (np.zeros(len(prepared.scene.bodies), dtype=np.int64) for _ in range(2))
    moving = [(visibility.scatterers, visibility.all_round(0).body) for visibility in _visibilities(prepared)]
    for bodies, body in ((prepared.resting_set, prepared.resting.body), *moving):
        scatterers[bodies.key] += bodies.scatterers
        echoes[bodies.key] += np.bincount(body, minlength=len(bodies))
    return PerBody(scatterers, echoes)


def _visibilities(prepared: Prepared) -> list[Visibility]:
    """The visibility of moving bodies, and of land under way."""
    land = [] if prepared.land is None else [prepared.land.echoes.visibility]
    return [prepared.moving.visibility, *land]


@dataclass
class Stopwatch:
    """CPU time [s] of each stage, of azimuths timed, and of each visibility update."""

    stages: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("moving", "receiver", "profiles", "aspects"), 0.0)
    )
    effects: dict[str, float] = field(default_factory=dict)
    azimuths: int = 0
    updates: dict[int, float] = field(default_factory=dict)
    _last: float = 0.0

    def start(self) -> None:
        """Starts a tile."""
        self._last = time.thread_time()

    def lap(self) -> float:
        """CPU time [s] since the last call."""
        last, self._last = self._last, time.thread_time()
        return self._last - last

    def add(self, stage: str) -> None:
        """Adds the time since the last call to a stage."""
        self.stages[stage] += self.lap()

    def add_effect(self, name: str) -> None:
        """Adds the time since the last call to an effect of `stages`."""
        self.effects[name] = self.effects.get(name, 0.0) + self.lap()


def timed_costs(prepared: Prepared) -> Costs:
    """CPU time of an azimuth on this machine.

    Measuring takes about MAX_SECONDS of CPU time, more where tiles are uneven, or that of MIN_TILES tiles where these take
    longer.
    """
    watch, begun = Stopwatch(), time.thread_time()
    tiles = -(-prepared.scene.radar.azimuths // prepared.tile)
    for stretch in _stretches(prepared, tiles, watch.updates):
        spent = time.thread_time() - begun
        if watch.azimuths >= MIN_TILES * prepared.tile and spent > MAX_SECONDS:
            break
        _compute(prepared, stretch[0] - 1, Stopwatch(updates=watch.updates))
        for tile in stretch:
            _compute(prepared, tile, watch)
    share = MICROSECONDS / watch.azimuths
    update = float(np.mean(list(watch.updates.values()))) * MICROSECONDS
    per_update = prepared.moving.visibility.interval / prepared.scene.radar.spoke_period
    own, effects = ({name: seconds * share for name, seconds in spent.items()} for spent in (watch.stages, watch.effects))
    return Costs(looks=update / per_update, effects=effects, **own)


def _stretches(prepared: Prepared, tiles: int, updates: dict[int, float]) -> Iterator[range]:
    """Stretches of the tiles of a scan: all in one where that is quick, otherwise such that any first few are spread evenly.

    updates: CPU time [s] of visibility updates, to which those of the end of the first scan are added.
    """
    for tile in (-min(2, tiles), -1):  # the first one also loads code and allocates memory
        begun = time.thread_time()
        _compute(prepared, tile, Stopwatch(updates=updates))
    if (time.thread_time() - begun) * tiles < MAX_SECONDS:
        yield range(tiles)
        return
    bounds = np.linspace(0, tiles, min(tiles // 2, STRETCHES) + 1).astype(np.int64) if tiles > 1 else np.array([0, 1])
    for k in _spread(len(bounds) - 1):
        yield range(int(bounds[k]), int(bounds[k + 1]))


def _spread(count: int) -> list[int]:
    """The numbers below `count`, each far from those before it (van der Corput 1935)."""
    bits = max(1, (count - 1).bit_length())
    turned = [int(f"{k:0{bits}b}"[::-1], 2) for k in range(2**bits)]
    return [k for k in turned if k < count]


def _compute(prepared: Prepared, tile: int, watch: Stopwatch) -> None:
    """Computes a tile of the second scan, as the engine and the simulator do; times each stage."""
    radar = prepared.scene.radar
    tiles = -(-radar.azimuths // prepared.tile)
    scan, number = divmod(SCAN * tiles + tile, tiles)
    watch.start()
    azimuths = tile_azimuths(prepared, scan, number * prepared.tile)
    blind = prepared.scene.blind(azimuths.time, azimuths.boresight)
    watch.add("profiles")
    for step in np.unique(visibility_steps(prepared, azimuths)).tolist():
        _update(prepared, step, watch)
    if len(prepared.moving.passages):
        for first, stop in blocks(prepared, azimuths):  # the results are cached for the rows
            prepared.moving.passing(azimuths.part(first, stop))
    watch.add("aspects")
    for name, stage in prepared.stages.items():
        for first, stop in blocks(prepared, azimuths) if stage.has_echoes else ():
            stage.echoes(azimuths.part(first, stop))
        watch.add_effect(name)
    rows = moving_rows(replace(prepared, stages={}), azimuths)
    land = land_spectra(prepared, azimuths, rows)
    watch.add("moving")
    profiles = receive(prepared, azimuths, rows if land is None else None, blind, land)
    watch.add("receiver")
    add_resting(prepared, profiles, azimuths, blind)
    watch.add("profiles")
    add_stages(prepared, Tile(azimuths, ~blind, profiles), after=watch.add_effect)
    square_law(profiles)
    radar.schedule(azimuths.number)
    prepared.scene.own_ship.pose(azimuths.time)
    watch.add("profiles")
    watch.azimuths += len(azimuths.time)


def _update(prepared: Prepared, step: int, watch: Stopwatch) -> None:
    """Computes a visibility update; the first of all is cached already and not counted."""
    prepared.shadows.at(step)
    if len(prepared.moving):
        prepared.moving.snapshot(step)
    update = watch.lap()
    if step:
        watch.updates.setdefault(step, update)
