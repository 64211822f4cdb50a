"""Counts and costs of a prepared engine: echoes, rays and transforms, and CPU times of its stages on this machine.

Counts come from the engine's own records and formulas. Costs are CPU times of the pipeline's stages over sample azimuths of a
scan. No choice depends on costs, except where the user limits time.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from radar_service.engine.pipeline import Prepared, moving_rows, receive, tile_azimuths
from radar_service.plan.culling import Culling
from radar_service.plan.statistics import Costs, Counts, EngineStatistics, PerBody
from radar_service.scattering.model import BodyEchoes

MAX_TIMED_TILES = 8  # evenly spaced over a scan, on which moving echoes are timed
CLUTTER_SHARE = 8  # one in so many tiles is timed for clutter, whose rows are computed dozens of azimuths at a time
MICROSECONDS = 1e6  # per second


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
    return EngineStatistics(set_up.culling, engine_counts(set_up), counts_per_body(prepared), engine_costs(prepared))


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


def engine_costs(prepared: Prepared) -> Costs:
    """CPU time of an azimuth on this machine."""
    updates, moving, receiver = _moving_costs(prepared)
    return Costs(updates, moving, receiver, _clutter(prepared), _interference(prepared), _handing_over(prepared))


def _visibility_update(prepared: Prepared, step: int) -> BodyEchoes:
    """Computes moving echoes and shadows of a visibility step; both are cached."""
    prepared.shadows.at(step)
    return prepared.moving.snapshot(step).echoes


def _moving_costs(prepared: Prepared) -> tuple[float, float, float]:
    """Costs per azimuth [us] of visibility updates, of moving echoes, and of the receiver: means over tiles of a scan.

    The first visibility step is cached already, so it is timed only where there is no other.
    """
    radar, interval = prepared.scene.radar, prepared.moving.visibility.interval
    blind, updates = np.zeros(min(prepared.tile, radar.azimuths), dtype=np.bool_), dict[int, float]()
    moving = total = 0.0
    last = (radar.azimuths - len(blind)) // prepared.tile
    starts = np.unique(np.linspace(0, last, MAX_TIMED_TILES).astype(np.int64)) * prepared.tile
    for start in starts:
        azimuths = tile_azimuths(prepared, 0, int(start))
        step = int(azimuths.middle // interval)
        seconds = _seconds(partial(_visibility_update, prepared, step), times=1)
        if step:
            updates.setdefault(step, seconds)
        prepared.moving.passing(azimuths)
        moving += _seconds(lambda azimuths=azimuths: moving_rows(prepared, azimuths))  # type: ignore[misc]
        total += _seconds(lambda azimuths=azimuths: receive(prepared, azimuths, moving_rows(prepared, azimuths), blind))  # type: ignore[misc]
    each = MICROSECONDS / (len(starts) * len(blind))
    update = float(np.mean(list(updates.values()))) if updates else _repeated_update(prepared)
    per_update = interval / radar.spoke_period
    looks = update / per_update + _passages(prepared) / radar.azimuths
    return looks * MICROSECONDS, moving * each, max(0.0, total - moving) * each


def _passages(prepared: Prepared) -> float:
    """CPU time [s] of physical optics of moving bodies within a scan: each body at each node of its first passage."""
    passages = prepared.moving.passages
    return sum(
        _seconds(partial(passages.evaluated, n, nodes[0])) * len(nodes) for n, nodes in enumerate(passages.first_nodes())
    )


def _repeated_update(prepared: Prepared) -> float:
    """CPU time [s] of a visibility update where a scan has at most one."""
    visibility = prepared.moving.visibility
    visibility.scatterers.clear()
    visible = _seconds(partial(visibility.scatterers.steady.echoes, *visibility.observed_at(0)), times=1)
    return visible + _seconds(partial(prepared.shadows.computed, 0))


def _clutter(prepared: Prepared) -> float:
    """Cost of clutter per azimuth [us]."""
    if prepared.clutter is None:
        return 0.0
    clutter, radar = prepared.clutter, prepared.scene.radar
    tiles = max(4, math.ceil(radar.azimuths / prepared.tile / CLUTTER_SHARE))
    index = np.arange(min(prepared.tile, radar.azimuths))
    profiles, transmitting = np.zeros((len(index), radar.bins), dtype=np.complex64), np.ones((len(index), 1), dtype=np.bool_)
    clutter.add(profiles, index, transmitting)  # computes the rows before north, which occur once
    start = time.thread_time()
    for tile in range(1, tiles):
        clutter.add(profiles, (tile * prepared.tile + index) % radar.azimuths, transmitting)
    return (time.thread_time() - start) / ((tiles - 1) * len(index)) * MICROSECONDS


def _interference(prepared: Prepared) -> float:
    """Cost of interference per azimuth [us]."""
    if not prepared.interference:
        return 0.0
    radar = prepared.scene.radar
    number = np.arange(min(prepared.tile, radar.azimuths))
    boresight, transmitted = radar.schedule(number)
    profiles = np.zeros((len(number), radar.bins), dtype=np.complex64)
    once = sum(_seconds(partial(other.add, profiles, boresight, transmitted)) for other in prepared.interference)
    return once / len(number) * MICROSECONDS


def _handing_over(prepared: Prepared) -> float:
    """Cost per azimuth [us] of the schedule, own ship's pose, resting profiles and detection."""
    field = np.ones((prepared.tile, prepared.scene.radar.bins), dtype=np.complex64)
    resting = np.zeros(1, dtype=np.complex64) if prepared.resting_profiles is None else field

    def handed_over() -> None:
        for _ in range(2):  # once for the tile, once for the spokes made of it
            azimuths = tile_azimuths(prepared, 0, 0)
            prepared.scene.own_ship.pose(azimuths.time)
        prepared.scene.blind(azimuths.time, azimuths.boresight)
        np.add(field, resting, out=field)
        np.add(field.real**2, field.imag**2)

    return _seconds(handed_over) / prepared.tile * MICROSECONDS


def _seconds(work: Callable[[], object], times: int = 2) -> float:
    """CPU time [s] of a function: the minimum of some calls."""
    seconds = []
    for _ in range(times):
        start = time.thread_time()
        work()
        seconds.append(time.thread_time() - start)
    return min(seconds)
