"""The simulator computes spokes, scans and the truth from a scene, a fidelity and a seed. Its only clock is simulated time."""

import math
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import cached_property
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np

from radar_service.engine.preparation import Prepared
from radar_service.errors.reporter import ErrorReporter
from radar_service.numerics import BLAS_LIMIT, Floats, Indices, Singles
from radar_service.plan.plan import Plan
from radar_service.receive import receiver_noise_power
from radar_service.records import (
    Crossing,
    Fidelity,
    OwnShipTruth,
    PowersOf,
    Readings,
    ShipStates,
    Snapshot,
    Spoke,
    SpokeBlock,
    Truth,
    regrouped,
    source_request,
)
from radar_service.scans import Sector
from radar_service.scene_file import changed_errors
from radar_service.simulation.engine_set_up import (
    SourceTile,
    SourceTiles,
    SourceTruth,
    check_arguments,
    chosen_fidelity,
    engine_set_up,
)
from radar_service.simulation.tile_processes import TileProcesses, shared_out
from radar_service.spoke_source import SpokeSourceInfo, TruthLine
from radar_service.trace import TREES
from radar_service.truth.crossings import CrossingTruth
from radar_service.truth.ground_truth import GroundTruth
from radar_service.truth.truth_file import header
from radar_service.world import Command, ErrorSettings, Scene, Steering, command_from, outline_of, scene_at_rpm

if TYPE_CHECKING:
    from radar_service.scans import Scan


class Simulator:
    """One radar turning in one scene. `scene` is the scene as this radar has it.

    The first scan starts at t = 0 at north and is complete: the beam wraps. On one machine the
    same scene, fidelity and seed give the same bytes. Not thread-safe, except `truth`. BLAS libraries
    are kept to one thread while set-up, `plan` or a block is computed (`parallel.BLAS_LIMIT`), and only then.
    """

    @BLAS_LIMIT.held()
    def __init__(
        self, scene: Scene, fidelity: str | Fidelity = "auto", seed: int = 0, threads: int = 1,
        sector: tuple[float, float] | None = None, commands: Iterable[Command | Mapping[str, Any]] = (), labels: bool = False,
        radar: str | None = None, powers: PowersOf = (),
    ) -> None:  # fmt: skip
        """fidelity: a preset's name, a Fidelity, or `auto`: planned for this scene and the default error budget; threads: how
        many processes compute at once (on Linux; elsewhere one), which changes no byte; sector: from and to, clockwise from true
        north [rad]: only its azimuths are computed, with the bytes that they have in a whole scan; commands: to replay, as
        `commands` of another run; labels: whether spokes name the strongest source of each cell, which changes no other byte;
        radar: id of one of the scene's radars, by default the first; powers: `all`, or the numbers of the sources whose power
        the spokes have too.

        Raises TypeError and ValueError as `check_arguments`, and ValueError for an unknown name or radar, labels or powers that
        the radar cannot tell or has no source for, or a command that is not possible (CommandError).
        """
        check_arguments(scene, seed, threads, sector)
        scene = scene.for_radar(radar)
        self._steering = steering = Steering(scene)
        self.scene, self.seed, self.fidelity = scene, seed, chosen_fidelity(scene, fidelity)
        self._threads, self._ends = threads, sector
        self._made = engine_set_up(steering.scene, self.fidelity, fidelity, seed)
        self.range, self.range_step = self._made.engine.range, scene.radar.range_step
        self.noise_power = receiver_noise_power(scene.radar)
        self._request, self._requests, self._again = source_request(labels, powers), 0, math.inf
        engine, _, line_of_sight, pulses = self._made
        if steering.past is not steering.scene:
            line_of_sight = line_of_sight.following(steering.past.bodies, steering.past.revision)
        self._truth = GroundTruth(steering.past, line_of_sight, self.fidelity.sampler)
        self._sources = SourceTruth(steering, self.fidelity, fidelity, self.seed, pulses)
        self._reporter = ErrorReporter(
            self.scene.radar,
            self.seed,
            self.scene.errors,
            self.scene.radar_id,
            ship=self.scene.platform.body,
            stream=self.scene.environment.stream,
        )
        tiles = SourceTiles(engine, pulses, self._request)
        self.sources = tiles.sources(self.scene)
        self.sources.check(self._request)
        self._tiles = shared_out(tiles, steering, threads)
        self._sector = Sector(self.scene.radar, sector)
        self._next_scan = self._next_spoke = self._first = 0  # what comes next, and the spoke of the last skip
        self._commanding = Lock()
        if commands := tuple(commands):
            self.replay(commands)

    def __repr__(self) -> str:
        name, fidelity, scan = self.scene.name, self.fidelity.name, self._next_scan
        return f"<Simulator of {name!r}: fidelity {fidelity}, seed {self.seed}, next is scan {scan}>"

    @cached_property
    @BLAS_LIMIT.held()
    def plan(self) -> Plan:
        """What is modelled and what is not, why, at what error and cost; costs are measured at the first access."""
        return self._made.plan(self.scene, self.fidelity)

    @property
    def info(self) -> SpokeSourceInfo:
        """What is known of it before its first spoke, its plan included."""
        return self.described(self.plan.as_dict())

    @property
    def unmeasured_info(self) -> SpokeSourceInfo:
        """`info` with a plan without counts and costs, which take a second to measure."""
        return self.described(self._made.plan(self.scene, self.fidelity, measured=False).as_dict())

    def described(self, plan: Mapping[str, Any]) -> SpokeSourceInfo:
        """Returns `info` with a plan as plain data, which is not made then."""
        return SpokeSourceInfo(
            outline_of(self.scene),
            self.seed,
            self.fidelity,
            plan,
            self.noise_power,
            self.range,
            self.range_step,
            self.sources,
        )

    @property
    def processes(self) -> list[int]:
        """Numbers of the processes that compute with it now, where it has several `threads`."""
        return self._tiles.numbers if isinstance(self._tiles, TileProcesses) else []

    @property
    def trees(self) -> int:
        """Number of trees for ray tests that this process holds, for all simulators together."""
        return TREES.live

    def scan(self) -> "Scan":
        """The next scan. Azimuths outside the sector are NaN."""
        from radar_service.scans import scan_of  # here: its pictures would slow every start of the service

        azimuths = self.scene.radar.azimuths
        return scan_of(self.blocks(scans=1, size=azimuths), azimuths)

    @property
    def pulses(self) -> tuple[Prepared, ...]:
        """The scene prepared for each pulse of the radar; none for the fidelity `documented`."""
        return self._made.pulses

    def reported(self, number: Indices) -> Readings:
        """Returns boresight and own ship of spokes of these numbers (K,) as they report them, by the errors of the first."""
        laws, true = self._reporter.laws_at(int(number[0])), self._readings_of(number)
        return true if laws is None else laws.reported(number, self.scene.radar.schedule(number)[1], true, self._readings_of)

    def spokes(self, scans: int | None = None) -> Iterator[Spoke]:
        """The spokes of the next `scans` scans one by one, in order; None: without end."""
        for block in self.blocks(scans):
            yield from block.spokes()

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        """Consecutive spokes from the next scan on, in blocks that never span two scans.

        scans: how many, None: without end; a scan counts as taken with its first block. size: spokes per block (the last of a
        scan may be shorter); it changes no byte.
        """
        azimuths = self.scene.radar.azimuths
        at, left = self._next_scan * azimuths, math.inf if scans is None else scans
        while left > 0:
            self._begin(at)
            with closing(self._rest_of_scan(at, size)) as blocks:
                while (block := _computed(blocks)) is not None:
                    part = self._as_commanded(block)
                    if part is not None:
                        yield self._reporter.reported(part, self._readings_of) if self._reporter.has_errors else part
                    if self._due <= self._next_spoke:
                        break
            scan, back = at // azimuths, self._overtaken()
            at = self._next_scan * azimuths if back is None else back
            left -= 1 if back is None else back // azimuths - scan

    def feed(self, scans: int | None = None) -> Iterator[Spoke]:
        """The spokes of the next `scans` scans as a client of the service receives them, with the errors of the feed.

        Spokes that are late at the end of the last scan come with the next call. None: without end.
        """
        for block in self.blocks(scans):
            for sent in self._reporter.sent(block):
                yield from sent.spokes()

    def set_errors(self, tables: Mapping[str, Any] | None) -> None:
        """Changes errors on purpose, from the first spoke that was not yet yielded.

        tables: those of `[errors]` in a scene file; each replaces the one in force, and None switches it off. None for all
        switches all off. Raises SceneError.
        """
        errors = changed_errors(self.errors, tables, self.scene.has_sensors)
        self._reporter.set(errors, self._next_spoke)

    @property
    def errors(self) -> ErrorSettings | None:
        """The errors on purpose of the spokes to come."""
        return self._reporter.errors

    @property
    def label_names(self) -> dict[int, str]:
        """The name of each source that a label may be the number of, by rising number."""
        return dict(self.sources.names)

    def request_sources(self, labels: bool = False, powers: PowersOf = (), spoke: int | None = None) -> None:
        """Changes what the spokes tell of their sources: labels, and powers as `Simulator` takes them. No other byte
        changes.

        spoke: the first one that shows it, by default the first one after the blocks taken so far. With an earlier one, a running
        `blocks` goes back there, and repeats spokes. May be called from any thread. Raises ValueError for what the radar cannot
        tell, and then nothing changes.
        """
        request = source_request(labels, powers)
        self.sources.check(request)
        with self._commanding:
            self._request, self._requests = request, self._requests + 1
            self._again = min(self._again, self._next_spoke if spoke is None else max(spoke, 0))

    @BLAS_LIMIT.held()
    def source_powers(self, scan: int | None = None) -> dict[int, Singles]:
        """The power (A, N) [W] of each source alone in a scan, by source number; by default in the scan that was taken last.

        Noise is its mean, speckle as drawn. A source without power is left out. The scan is computed again, and each source
        compressed by itself. Raises ValueError for the fidelity `documented`.
        """
        return self._sources.powers(self._latest(scan))

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one, counted from 0 at t = 0. Commands that act earlier are followed from there on."""
        self._next_scan = max(scan, 0)
        self._next_spoke = self._first = self._next_scan * self.scene.radar.azimuths
        self._reporter = self._reporter.restarted(self._next_spoke)

    def command(
        self, body: str | None = None, *, spoke: int | None = None, time: float | None = None, **values: Any
    ) -> Command:
        """Steers own ship (None) or a body that the scene declares steerable; returns the command with its spoke and time.

        values: as the fields of `Command`, such as course_deg=90. spoke: the first one that shows it, by default the first one
        after the blocks taken so far. time: at which it acts [s], instead of a spoke: the first one not before it shows it.
        With an earlier one, a running `blocks` goes back there, and repeats spokes. May be called from any thread. Raises
        CommandError, and then nothing changes.
        """
        with self._commanding:
            at = self._next_spoke if spoke is None and time is None else spoke
            return self._steering.add(at, body, values, self._next_spoke, time)

    def take(self, command: Command) -> None:
        """Takes a command that was made for this scene, by another simulator of it. It acts as one of `command`."""
        with self._commanding:
            self._steering.take(command, self._next_spoke)

    @property
    def commands(self) -> tuple[Command, ...]:
        """All commands so far, by time: with them another simulator of the same scene makes the same bytes."""
        return self._steering.commands

    def replay(self, commands: Iterable[Command | Mapping[str, Any]]) -> None:
        """Replaces all commands by those of another run, as `commands` gives them or as plain data. Call it between blocks.

        Raises CommandError, and then nothing changes.
        """
        self._steering.replay([each if isinstance(each, Command) else command_from(each) for each in commands])

    def at_rpm(self, rpm: float) -> "Simulator":
        """Returns a simulator of the same scene at another rate of rotation, next the first scan after those of this one.

        Simulated time, positions, commands and errors go on; scans and spokes are counted as if the antenna had always turned at
        that rate. Raises SceneError where the rate leaves no pulse for a spoke.
        """
        scene, request = scene_at_rpm(replace(self.scene, errors=self.errors), rpm), self._request
        commands = [scene.steerable.seen(each, each.body) for each in self.commands]
        sim = Simulator(
            scene, self.fidelity, self.seed, self._threads, self._ends, commands, request.labels, powers=request.powers
        )
        sim.skip_to(scene.radar.first_scan(self.scene.radar.time_of_turns(float(self._next_scan))))
        return sim

    def truth(self, t: float) -> Truth:
        """State of own ship and of every body at time t [s]. Safe to call from another thread."""
        return self._truth.at(t)

    def ship_states(self, times: Sequence[float], names: Sequence[str | None] = (None,)) -> list[ShipStates]:
        """True states of ships at times [s], as commanded then: of bodies by name, of own ship for None; what a radar sees of
        them does not count. Safe to call from another thread. Raises KeyError for a name that no body has."""
        return self._steering.past.ship_states(times, names)

    def crossings(self, scan: int | None = None, radiometric: bool = False, count: int = 1) -> tuple[Crossing, ...]:
        """The truth of each time that the boresight met a body in so many scans, by time; by default in the one taken last.

        A body near north may be crossed twice in a scan, or not at all. radiometric: whether to measure the power of each body
        too, for which the engine computes the azimuths about it again. Safe to call from another thread. Raises ValueError
        where radiometric truth is asked of the fidelity `documented`.
        """
        crossings = self._crossings.crossings(self._latest(scan), count)
        if crossings and self._reporter.has_errors:
            of_each = zip(*((each.own_ship, each.scan, each.spoke) for each in crossings), strict=True)
            reported = self._with_reports(*of_each)
            crossings = tuple(replace(each, own_ship=own) for each, own in zip(crossings, reported, strict=True))
        return self._measured(crossings) if radiometric else crossings

    def snapshot(self, scan: int | None = None) -> Snapshot:
        """The truth of all bodies at the end of a scan, by default of the scan that was taken last."""
        snapshot = self._crossings.snapshot(number := self._latest(scan))
        last = self._reporter.last_spoke(number)
        (own_ship,) = self._with_reports([snapshot.own_ship], [number], [last])
        return replace(snapshot, own_ship=own_ship, feed_errors=self._reporter.counts(number))

    def truth_header(self) -> dict[str, Any]:
        """What a truth file says first: the scene, the seed, the fidelity and the radar."""
        return header(self.scene, self.seed, self.fidelity.name)

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
        """The lines of a truth file of a scan, see `crossings` and `snapshot`; the header for None."""
        if scan is None:
            return [TruthLine.of_content(0.0, self.truth_header())]
        return [*map(TruthLine.of, self.crossings(scan, radiometric)), TruthLine.of(self.snapshot(scan))]

    def close(self) -> None:
        """Ends the processes that compute with it, where it has several `threads`; the next block starts others."""
        if isinstance(self._tiles, TileProcesses):
            self._tiles.close()

    @cached_property
    def _crossings(self) -> CrossingTruth:
        """Made when it is first asked: most runs need none."""
        return CrossingTruth(self._truth)

    def _latest(self, scan: int | None) -> int:
        return max(0, self._next_scan - 1) if scan is None else scan

    @BLAS_LIMIT.held()
    def _measured(self, crossings: tuple[Crossing, ...]) -> tuple[Crossing, ...]:
        """The crossings with their radiometric part."""
        return self._sources.measured(crossings)

    def _begin(self, spoke: int) -> None:
        """Makes ready to compute from this spoke on, as commanded until there."""
        with self._commanding:
            self._next_scan, self._next_spoke = spoke // self.scene.radar.azimuths + 1, spoke
            self._steering.go_to(spoke)
            self._tiles.request = self._request
            self._again = math.inf if max(self._again, self._first) >= spoke else self._again

    def _rest_of_scan(self, spoke: int, size: int) -> Generator[SpokeBlock, None, None]:
        """The blocks from this spoke to the end of its scan."""
        scan, index = divmod(spoke, self.scene.radar.azimuths)
        sector = self._sector.after(index)
        computed = (self._block(scan, SourceTile(*tile)) for tile in self._tiles.scan(scan, sector.requested))
        for stretch in sector.stretches(computed):
            yield from regrouped(stretch, size)

    def _block(self, scan: int, tile: SourceTile) -> SpokeBlock:
        radar = self.scene.radar
        number = scan * radar.azimuths + np.arange(tile.start, tile.start + len(tile.field))
        boresight, time = radar.schedule(number)
        return SpokeBlock(
            int(number[0]), scan, tile.start, time, *self._readings(boresight, time), self.range, self.range_step,
            tile.field, tile.power, labels=tile.labels, powers=tile.powers,
        )  # fmt: skip

    def _as_commanded(self, block: SpokeBlock) -> SpokeBlock | None:
        """The spokes of a block before the next command or request, which count as taken from now on; None: there are none."""
        with self._commanding:
            count = min(len(block), int(min(self._due, block.first + len(block))) - block.first)
            self._next_spoke = block.first + max(count, 0)
            if count <= 0:
                return None
            part = block if count == len(block) else block.part(0, count)
            count, requests = self._steering.count, self._requests
            return replace(part, commands=count, requests=requests) if count or requests else part

    @property
    def _due(self) -> float:
        """The first spoke that what is computed now does not hold for, none before that of the last skip."""
        return max(min(self._steering.due, self._again), self._first)

    def _overtaken(self) -> int | None:
        """The spoke to go on from where a command or a request acts that the last blocks do not show; else None."""
        with self._commanding:
            return int(self._due) if self._due <= self._next_spoke else None

    def _readings_of(self, number: Indices) -> Readings:
        """True boresight and own ship of spokes of these numbers (K,), which are computed or earlier ones."""
        return self._readings(*self.scene.radar.schedule(number))

    def _readings(self, boresight: Floats, time: Floats) -> Readings:
        """The readings of spokes at boresights [rad] and times [s] (K,)."""
        own = self._steering.past.own_ship.pose(time)
        return Readings(boresight, own.heading, own.position[:, :2], own.course, own.speed)

    def _with_reports(self, own: Sequence[OwnShipTruth], scans: Sequence[int], spokes: Sequence[int]) -> list[OwnShipTruth]:
        """Own ship with what the nearest spokes of scans report."""
        nearest = [min(spoke, self._reporter.last_spoke(scan)) for scan, spoke in zip(scans, spokes, strict=True)]
        reports = self._reporter.own_ships(own, nearest, self._readings_of)
        return [replace(each, reported=report) for each, report in zip(own, reports, strict=True)]


@BLAS_LIMIT.held()
def _computed(blocks: Iterator[SpokeBlock]) -> SpokeBlock | None:
    """The next block, None at the end. The limit is held while it is computed, and not while the consumer has it."""
    return next(blocks, None)
