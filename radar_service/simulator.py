"""The simulator computes spokes, scans and the truth from a scene, a fidelity and a seed. Its only clock is simulated time."""

import itertools
from collections.abc import Iterator
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from radar_service.engine.documented import DocumentedEngine
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import Prepared, prepare
from radar_service.engine.stitched import StitchedEngine
from radar_service.fidelity import Fidelity, fidelity_from_name
from radar_service.frames import effective_earth_radius
from radar_service.parallel import BLAS_LIMIT
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.cost_model import SetUp, engine_statistics, first_visibility_update
from radar_service.plan.culling import Culling, cull
from radar_service.plan.plan import Plan, plan_for
from radar_service.plan.settings_search import fidelity_for
from radar_service.receive.compression import receiver_noise_power
from radar_service.records import Crossing, Snapshot, Spoke, SpokeBlock, Truth, regrouped
from radar_service.scene.world import Scene
from radar_service.sector import Sector
from radar_service.trace.embree import TREES, RayCount
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.truth.crossings import CrossingTruth
from radar_service.truth.ground_truth import GroundTruth
from radar_service.truth.truth_file import header
from radar_service.types import Flags, Floats, Profiles, Singles

if TYPE_CHECKING:
    from radar_service.scan import Scan


class AzimuthEngine(Protocol):
    """What computes the scans of a simulator: the pipeline, or the specification as printed."""

    range: Floats  # (N,) m, where the samples stand

    def tiles(self, scan: int, requested: Flags | None = None) -> Iterator[tuple[int, Profiles, Singles]]:
        """One scan: index of each tile's first azimuth, field (K, N) [sqrt(W)] and power (K, N) [W].

        requested: flags of azimuths (A,); tiles without any may be left out.
        """
        ...


class Simulator:
    """One radar turning in one scene.

    The first scan starts at t = 0 at north and is complete: the beam wraps. On one machine the
    same scene, fidelity and seed give the same bytes. Not thread-safe, except `truth`. BLAS libraries
    are kept to one thread while set-up, `plan` or a block is computed (`parallel.BLAS_LIMIT`), and only then.
    """

    @BLAS_LIMIT.held()
    def __init__(
        self, scene: Scene, fidelity: str | Fidelity = "auto", seed: int = 0, threads: int = 1,
        sector: tuple[float, float] | None = None,
    ) -> None:  # fmt: skip
        """fidelity: a preset's name, a Fidelity, or `auto`: planned for this scene and the default error budget; threads: how
        many compute at once, which changes no byte; sector: from and to, clockwise from true north [rad]: only its azimuths
        are computed, with the bytes that they have in a whole scan.

        Raises ValueError for an unknown name, a negative seed, fewer than one thread or a sector that is not two angles.
        """
        if not 0 <= seed < 2**64:
            raise ValueError(f"seed: {seed} is not allowed; a whole number from 0 to 2**64 - 1")
        if threads < 1:
            raise ValueError(f"threads: {threads} is not allowed; 1 or more, best as many as there are cores to spare")
        if sector is not None and (len(sector) != 2 or not np.isfinite(sector).all()):
            raise ValueError(f"sector: {sector} is not allowed; two angles [rad] clockwise from north, as (0.0, 0.3)")
        self.scene, self.seed, self.fidelity = scene, seed, _fidelity(scene, fidelity)
        self._sector = Sector(scene.radar, sector)
        self._engine: AzimuthEngine
        self._set_up: SetUp | None = None  # of the pipeline; the specification as printed has no plan of its own
        if self.fidelity.engine == "documented":
            self._engine = DocumentedEngine(scene, self.fidelity, seed)
            line_of_sight = OcclusionScene(scene.bodies, effective_earth_radius(scene.environment.earth_factor))
        else:
            self._set_up = _set_up(scene, self.fidelity, seed)
            self._engine = Engine(self._set_up.prepared, threads)
            if scene.radar.near_pulses:
                self._engine = StitchedEngine(
                    scene, partial(_prepared, fidelity=fidelity, seed=seed), self._set_up.prepared, threads
                )
            line_of_sight = self._set_up.prepared.line_of_sight
        self.range, self.range_step = self._engine.range, scene.radar.range_step
        self.noise_power = receiver_noise_power(scene.radar)
        self._truth = GroundTruth(scene, line_of_sight)
        self._next_scan = 0

    def __repr__(self) -> str:
        return (
            f"<Simulator of {self.scene.name!r}: fidelity {self.fidelity.name}, seed {self.seed}, "
            f"next is scan {self._next_scan}>"
        )

    @cached_property
    @BLAS_LIMIT.held()
    def plan(self) -> Plan:
        """What is modelled and what is not, why, at what error and cost; costs are measured at the first access."""
        if self._set_up is None:
            return plan_for(self.scene, self.fidelity)
        return plan_for(self.scene, self.fidelity, engine_statistics(self._set_up))

    @property
    def trees(self) -> int:
        """Number of trees for ray tests that this process holds, for all simulators together."""
        return TREES.live

    def scan(self) -> "Scan":
        """The next scan. Azimuths outside the sector are NaN."""
        from radar_service.scan import scan_of  # here: the service makes no scans, and its pictures would slow every start

        return scan_of(self.blocks(scans=1), self.scene.radar.azimuths)

    def spokes(self, scans: int | None = None) -> Iterator[Spoke]:
        """The spokes of the next `scans` scans one by one, in order; None: without end."""
        for block in self.blocks(scans):
            yield from block.spokes()

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        """Consecutive spokes from the next scan on, in blocks that never span two scans.

        scans: how many, None: without end; a scan counts as taken with its first block. size: spokes per block (the last of a
        scan may be shorter); it changes no byte.
        """
        for _ in itertools.count() if scans is None else range(scans):
            number, self._next_scan = self._next_scan, self._next_scan + 1
            computed = (self._block(number, *tile) for tile in self._engine.tiles(number, self._sector.requested))
            for stretch in self._sector.stretches(computed):
                yield from BLAS_LIMIT.each(regrouped(stretch, size))

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one, counted from 0 at t = 0. Earlier ones are not computed."""
        self._next_scan = scan

    def truth(self, t: float) -> Truth:
        """State of own ship and of every body at time t [s]. Safe to call from another thread."""
        return self._truth.at(t)

    def crossings(self, scan: int | None = None) -> tuple[Crossing, ...]:
        """The truth of each time that the boresight met a body in a scan, by time; by default in the scan that was taken last.

        A body near north may be crossed twice in a scan, or not at all. Safe to call from another thread.
        """
        return self._crossings.crossings(self._latest(scan))

    def snapshot(self, scan: int | None = None) -> Snapshot:
        """The truth of all bodies at the end of a scan, by default of the scan that was taken last."""
        return self._crossings.snapshot(self._latest(scan))

    def truth_header(self) -> dict[str, Any]:
        """What a truth file says first: the scene, the seed, the fidelity and the radar."""
        return header(self.scene, self.seed, self.fidelity.name)

    @cached_property
    def _crossings(self) -> CrossingTruth:
        """Made when it is first asked: most runs need none."""
        return CrossingTruth(self._truth)

    def _latest(self, scan: int | None) -> int:
        return max(0, self._next_scan - 1) if scan is None else scan

    def _block(self, scan: int, start: int, field: Profiles, power: Singles) -> SpokeBlock:
        radar = self.scene.radar
        number = scan * radar.azimuths + np.arange(start, start + len(field))
        boresight, time = radar.schedule(number)
        own = self.scene.own_ship.pose(time)
        return SpokeBlock(
            int(number[0]), scan, start, time, boresight, own.heading, own.position[:, :2], own.course,
            own.speed, self.range, self.range_step, field, power,
        )  # fmt: skip


def _fidelity(scene: Scene, fidelity: str | Fidelity) -> Fidelity:
    """The requested fidelity for a scene."""
    if fidelity == "auto":
        return fidelity_for(scene, ErrorBudget())
    return fidelity_from_name(fidelity) if isinstance(fidelity, str) else fidelity


def _prepared(scene: Scene, fidelity: str | Fidelity, seed: int) -> Prepared:
    """The pipeline of a scene, with the fidelity planned for it where that is requested."""
    return _set_up(scene, _fidelity(scene, fidelity), seed).prepared


def _set_up(scene: Scene, fidelity: Fidelity, seed: int) -> SetUp:
    """Culls what the scene does not need, prepares the pipeline and runs the first visibility update."""
    rays = RayCount()
    culling: Culling = cull(scene, fidelity)
    prepared = prepare(culling.applied_to(scene), fidelity, seed, culling.silent, culling.transparent, rays)
    set_up_rays = rays.rays
    first_visibility_update(prepared)
    return SetUp(prepared, culling, set_up_rays, rays.rays - set_up_rays)
