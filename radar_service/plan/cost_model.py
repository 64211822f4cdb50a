"""What the engine will be asked for, counted once it is set up: echoes, rays, transforms, looks; and what that costs here.

Counts come from the engine's own records and formulas. Costs are CPU times of its own stages on this machine, taken over
some azimuths about the turn; choices never depend on them unless time is the budget.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from radar_service.engine.pipeline import CorrectedChain
from radar_service.scattering.rays import RaySampledSet
from radar_service.scattering.scatterer_set import BodyEchoes, ScattererSet, ScattererSource

Indices = NDArray[np.int64]
TILES = 8  # about the turn, over which laying is timed
CLUTTER_SHARE = 8  # of the turn clutter is timed: its rows are made some dozens of azimuths at a time
MICRO = 1e6


@dataclass(frozen=True)
class Counts:
    """What is done. set_up_rays, resting_echoes: once; look_rays, moving_echoes, shadowed_echoes: in the first look, of which
    there are looks_per_scan; transform_samples: of all transforms of one profile while something moves under the beam;
    scatterers: points on the bodies modelled."""

    resting_echoes: int
    moving_echoes: int
    shadowed_echoes: int
    scatterers: int
    set_up_rays: int
    visibility_rays: int
    visibility_updates_per_scan: float
    transform_samples: int


@dataclass(frozen=True)
class Costs:
    """CPU time of one thread per azimuth [us], on average over a revolution: of looking at what moves, of laying it, of the
    receiver with its noise and transforms, of sea and rain, of other radars, and of handing profiles over."""

    looks: float
    moving: float
    receiver: float
    clutter: float
    interference: float
    profiles: float

    @property
    def total(self) -> float:
        """All of it [us]."""
        return self.looks + self.moving + self.receiver + self.clutter + self.interference + self.profiles


@dataclass(frozen=True)
class PerBody:
    """Points laid on each body of the scene (B,), and its echoes (B,): at rest, or all round in the first glance."""

    scatterers: Indices
    echoes: Indices


def first_visibility_update(chain: CorrectedChain) -> int:
    """Has the engine look at what moves for its first glance, which it then need not do itself; the rays that this cast."""
    before = chain.rays
    chain.look(0)
    return chain.rays - before


def counts(chain: CorrectedChain, set_up_rays: int, visibility_rays: int) -> Counts:
    """What the engine does for a revolution. set_up_rays: cast before its first look, look_rays: in that."""
    seen, shadows = chain.look(0)
    gridded = len(chain.moving) > 0 or len(shadows.range) > 0
    return Counts(
        len(chain.resting),
        len(seen),
        len(shadows.range),
        int(sum(_points(ensemble).sum() for ensemble in (chain.still, chain.moving.ensemble))),
        set_up_rays,
        visibility_rays,
        chain.radar.rotation_period / chain.moving.interval,
        chain.compression.transformed(gridded, chain.scene.environment.noise),
    )


def per_body(chain: CorrectedChain) -> PerBody:
    """Points and echoes body by body."""
    scatterers, echoes = (np.zeros(len(chain.scene.bodies), dtype=np.int64) for _ in range(2))
    seen = _all_round(chain).body
    for ensemble, body in ((chain.still, chain.resting.body), (chain.moving.ensemble, seen)):
        scatterers[ensemble.key] += _points(ensemble)
        echoes[ensemble.key] += np.bincount(body, minlength=len(ensemble))
    return PerBody(scatterers, echoes)


def _points(ensemble: ScattererSource) -> Indices:
    """How many scatterers each body (B,) of an ensemble has."""
    scattered = ensemble.others if isinstance(ensemble, RaySampledSet) else ensemble
    assert isinstance(scattered, ScattererSet)
    found = np.zeros(len(ensemble), dtype=np.int64)
    found[np.searchsorted(ensemble.key, scattered.key)] = np.bincount(scattered.body, minlength=len(scattered))
    return found


def costs(chain: CorrectedChain) -> Costs:
    """What an azimuth costs on this machine."""
    looks, moving, receiver = _turn(chain)
    return Costs(looks, moving, receiver, _clutter(chain), _interference(chain), _handing_over(chain))


def _all_round(chain: CorrectedChain) -> BodyEchoes:
    """What is seen of all that moves in the middle of the first glance, wherever the beam is."""
    moment, moving = 0.5 * chain.moving.interval, chain.moving
    return moving.ensemble.reflections(chain.occlusion, chain.scene.antenna(moment)[0], moment, moving.reach)


def _turn(chain: CorrectedChain) -> tuple[float, float, float]:
    """Looks, laying what moves, and the receiver without that, per azimuth [us]: means over tiles about the turn, each in its
    own glance. The first glance has been looked at, so it is timed only where there is no other."""
    silent, looks = np.zeros(min(chain.rows, chain.radar.azimuths), dtype=np.bool_), dict[int, float]()
    laying = whole = 0.0
    last = (chain.radar.azimuths - len(silent)) // chain.rows
    starts = np.unique(np.linspace(0, last, TILES).astype(np.int64)) * chain.rows
    for start in starts:
        at = chain.instants(0, int(start))
        visibility_step = int(at.middle // chain.moving.interval)
        taken = _seconds(partial(chain.look, visibility_step), times=1)
        if visibility_step:
            looks.setdefault(visibility_step, taken)
        laying += _seconds(partial(chain._laid_moving, at))
        whole += _seconds(partial(chain._received, at, silent, 0, int(start)))
    each = MICRO / (len(starts) * len(silent))
    look = float(np.mean(list(looks.values()))) if looks else _look_anew(chain)
    per_look = chain.moving.interval / chain.radar.spoke_period
    return look / per_look * MICRO, laying * each, max(0.0, whole - laying) * each


def _look_anew(chain: CorrectedChain) -> float:
    """CPU time [s] of a look, where there is one in a revolution or fewer."""
    chain.moving.ensemble.forget()
    sight = _seconds(partial(_all_round, chain), times=1) if len(chain.moving) else 0.0
    moment = 0.5 * chain.moving.interval
    return sight + _seconds(partial(chain.resting.shadows, chain.occlusion, moment))


def _clutter(chain: CorrectedChain) -> float:
    if chain._clutter is None:
        return 0.0
    clutter, radar = chain._clutter, chain.radar
    tiles = max(4, math.ceil(radar.azimuths / chain.rows / CLUTTER_SHARE))
    index = np.arange(min(chain.rows, radar.azimuths))
    profiles, transmitting = np.zeros((len(index), radar.bins), dtype=np.complex64), np.ones((len(index), 1), dtype=np.bool_)
    clutter.add(profiles, index, transmitting)  # makes the rows behind north, which come once
    begun = time.thread_time()
    for tile in range(1, tiles):
        clutter.add(profiles, (tile * chain.rows + index) % radar.azimuths, transmitting)
    return (time.thread_time() - begun) / ((tiles - 1) * len(index)) * MICRO


def _interference(chain: CorrectedChain) -> float:
    if not chain._interference:
        return 0.0
    number = np.arange(min(chain.rows, chain.radar.azimuths))
    boresight, instant = chain.radar.schedule(number)
    profiles = np.zeros((len(number), chain.radar.bins), dtype=np.complex64)
    once = sum(_seconds(partial(other.add, profiles, boresight, instant)) for other in chain._interference)
    return once / len(number) * MICRO


def _handing_over(chain: CorrectedChain) -> float:
    """Saying when and where a tile is, adding what rests, and taking the power."""
    field = np.ones((chain.rows, chain.radar.bins), dtype=np.complex64)

    def handed() -> None:
        for _ in range(2):  # once for the tile, once for the spokes made of it
            at = chain.instants(0, 0)
            chain.scene.own_ship.pose(at.time)
        chain.scene.blind(at.time, at.boresight)
        np.add(field, 0.0 if chain._profiles is None else field, out=field)
        np.add(field.real**2, field.imag**2)

    return _seconds(handed) / chain.rows * MICRO


def _seconds(work: Callable[[], object], times: int = 2) -> float:
    """CPU time [s] of doing something, the least of some."""
    taken = []
    for _ in range(times):
        begun = time.thread_time()
        work()
        taken.append(time.thread_time() - begun)
    return min(taken)
