"""The simulator: a scene, a fidelity and a seed in; spokes, scans and the truth out. The only clock is simulated time."""

import itertools
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from radar_service.engine.documented import DocumentedEngine
from radar_service.engine.pipeline import CorrectedChain
from radar_service.fidelity import Fidelity, fidelity_from_name
from radar_service.frames import effective_earth_radius
from radar_service.parallel import BLAS_LIMIT
from radar_service.plan import cost_model
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.culling import culled_bodies, negligible_effects, without
from radar_service.plan.plan import Plan, plan_for
from radar_service.plan.settings_search import fidelity_for
from radar_service.plan.statistics import EngineStatistics
from radar_service.receive.compression import receiver_noise_power
from radar_service.records import Spoke, SpokeBlock, Truth, regrouped
from radar_service.scan import Scan, scan_of
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.truth import GroundTruth

Profiles = NDArray[np.complex64]
Powers = NDArray[np.float32]


def _chosen(scene: Scene, fidelity: str | Fidelity) -> Fidelity:
    """The fidelity meant for a scene."""
    if fidelity == "auto":
        return fidelity_for(scene, ErrorBudget())
    return fidelity_from_name(fidelity) if isinstance(fidelity, str) else fidelity


class Simulator:
    """One radar turning in one scene.

    The first scan starts at t = 0 looking north and is whole (the beam wraps). Same scene, fidelity and seed on one
    machine: the same bytes. Not thread-safe, except `truth`. BLAS libraries are kept to one thread while set-up, `plan` or a
    block is computed (`parallel.BLAS_LIMIT`), and only then.
    """

    @BLAS_LIMIT.held()
    def __init__(self, scene: Scene, fidelity: str | Fidelity = "auto", seed: int = 0, threads: int = 1) -> None:
        """fidelity: a preset's name, a Fidelity, or `auto`: planned for this scene and the default error budget; threads: how
        many work at once, which changes no byte.

        Raises ValueError for an unknown name, a negative seed or fewer than one thread.
        """
        if not 0 <= seed < 2**64:
            raise ValueError(f"seed: {seed} is not allowed; a whole number from 0 to 2**64 - 1")
        if threads < 1:
            raise ValueError(f"threads: {threads} is not allowed; 1 or more, best as many as there are cores to spare")
        self.scene, self.seed = scene, seed
        self.fidelity = _chosen(scene, fidelity)
        self._omissions, self._idle = culled_bodies(scene, self.fidelity), negligible_effects(scene, self.fidelity)
        never_seen = [key for key, omission in self._omissions.items() if not omission.hides]
        occlusion = OcclusionScene(scene.bodies, effective_earth_radius(scene.environment.earth_factor), never_seen)
        self._chain: DocumentedEngine | CorrectedChain = (
            DocumentedEngine(scene, self.fidelity, seed)
            if self.fidelity.chain == "documented"
            else CorrectedChain(without(self._idle, scene), self.fidelity, seed, occlusion, threads, self._omissions)
        )
        self._set_up_rays = self._look_rays = 0
        if isinstance(self._chain, CorrectedChain):
            self._set_up_rays = self._chain.rays
            self._look_rays = cost_model.first_visibility_update(self._chain)
        self.range, self.range_step = self._chain.range, scene.radar.range_step
        self.noise_power = receiver_noise_power(scene.radar)
        self._truth = GroundTruth(scene, occlusion)
        self._next_scan = 0

    def __repr__(self) -> str:
        return (
            f"<Simulator of {self.scene.name!r}: fidelity {self.fidelity.name}, seed {self.seed}, "
            f"next is scan {self._next_scan}>"
        )

    @cached_property
    @BLAS_LIMIT.held()
    def plan(self) -> Plan:
        """What is modelled and what is not, why, at what error and cost; costs are measured when it is first asked for."""
        chain = self._chain
        if isinstance(chain, DocumentedEngine):
            return plan_for(self.scene, self.fidelity)
        counts = cost_model.counts(chain, self._set_up_rays, self._look_rays)
        record = EngineStatistics(self._omissions, self._idle, counts, cost_model.per_body(chain), cost_model.costs(chain))
        return plan_for(self.scene, self.fidelity, record)

    def scan(self) -> Scan:
        """The next revolution."""
        return scan_of(self.blocks(scans=1))

    def spokes(self, scans: int | None = None) -> Iterator[Spoke]:
        """The spokes of the next `scans` revolutions one by one, in order; None for ever."""
        for block in self.blocks(scans):
            yield from block.spokes()

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        """Consecutive spokes from the next scan on, in blocks that never span two scans.

        scans: how many revolutions, None for ever; a scan counts as taken when its first block is. size: spokes per block
        (the last of a scan may be shorter); it changes no byte.
        """
        for _ in itertools.count() if scans is None else range(scans):
            number, self._next_scan = self._next_scan, self._next_scan + 1
            computed = (self._block(number, *part) for part in self._chain.parts(number))
            yield from BLAS_LIMIT.each(regrouped(computed, size))

    def skip_to(self, scan: int) -> None:
        """Let `scan` be the next one, counted from 0 at t = 0; earlier ones are not computed."""
        self._next_scan = scan

    def truth(self, t: float) -> Truth:
        """State of own ship and of every body at time t [s]. Safe to call from another thread."""
        return self._truth.at(t)

    def _block(self, scan: int, start: int, field: Profiles, power: Powers) -> SpokeBlock:
        radar = self.scene.radar
        number = scan * radar.azimuths + np.arange(start, start + len(field))
        boresight, time = radar.schedule(number)
        own = self.scene.own_ship.pose(time)
        return SpokeBlock(
            int(number[0]), scan, start, time, boresight, own.heading, own.position[:, :2], own.course,
            own.speed, self.range, self.range_step, field, power,
        )  # fmt: skip
