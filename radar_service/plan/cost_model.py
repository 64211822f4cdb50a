"""Counts and costs of a prepared engine: echoes, rays and transforms, and CPU times of its stages on this machine.

Counts come from the engine's own records and formulas. Costs are CPU times of tiles of a scan (`plan.timed_tiles`). No choice
depends on costs, except where the user limits time.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.engine.pipeline import tile_azimuths
from radar_service.engine.preparation import Prepared
from radar_service.plan.culling import Culling
from radar_service.plan.statistics import Counts, EngineStatistics, PerBody
from radar_service.plan.timed_tiles import timed_costs
from radar_service.scattering.model import BodyEchoes


@dataclass(frozen=True)
class SetUp:
    """A prepared engine.

    prepared: the engine.
    culling: what was culled before.
    set_up_rays: rays cast by preparation.
    look_rays: rays cast by the first visibility update.
    """

    prepared: Prepared
    culling: Culling
    set_up_rays: int
    look_rays: int


def first_visibility_update(prepared: Prepared) -> int:
    """Runs the first visibility update and returns the number of its moving echoes; the result is cached.

    Bodies by physical optics are evaluated as far as the beam passes them in the first tile.
    """
    passing = prepared.moving.passing(tile_azimuths(prepared, 0, 0))
    return len(_visibility_update(prepared, 0)) + (0 if passing is None else len(passing.echoes))


def engine_statistics(set_up: SetUp) -> EngineStatistics:
    """Counts and costs of an engine. Costs are measured now, which takes about a second."""
    prepared = set_up.prepared
    return EngineStatistics(set_up.culling, engine_counts(set_up), counts_per_body(prepared), timed_costs(prepared))


def engine_counts(set_up: SetUp) -> Counts:
    """Counts of what the engine computes."""
    prepared = set_up.prepared
    visible, shadows = first_visibility_update(prepared), prepared.shadows.at(0)
    radar, scattered = prepared.scene.radar, (prepared.resting_set, prepared.moving.visibility.scatterers)
    return Counts(
        len(prepared.resting),
        visible,
        len(shadows.range),
        int(sum(scatterers.scatterers.sum() for scatterers in scattered)),
        set_up.set_up_rays,
        set_up.look_rays,
        radar.rotation_period / prepared.moving.visibility.interval,
        prepared.compression.transformed(
            len(prepared.moving) > 0 or len(shadows.range) > 0, prepared.scene.environment.noise
        ),
    )


def counts_per_body(prepared: Prepared) -> PerBody:
    """Scatterers and echoes of each body."""
    scatterers, echoes = (np.zeros(len(prepared.scene.bodies), dtype=np.int64) for _ in range(2))
    visibility = prepared.moving.visibility
    sets = (prepared.resting_set, prepared.resting.body), (visibility.scatterers, visibility.all_round(0).body)
    for bodies, body in sets:
        scatterers[bodies.key] += bodies.scatterers
        echoes[bodies.key] += np.bincount(body, minlength=len(bodies))
    return PerBody(scatterers, echoes)


def _visibility_update(prepared: Prepared, step: int) -> BodyEchoes:
    """Computes moving echoes and shadows of a visibility step; both are cached."""
    prepared.shadows.at(step)
    return prepared.moving.snapshot(step).echoes
