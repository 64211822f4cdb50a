"""The simulator computes spokes, scans and the truth from a scene, a fidelity and a seed. Its only clock is simulated time."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from radar_service.engine.preparation import Prepared
from radar_service.errors.reporter import ErrorReporter
from radar_service.numerics import BLAS_LIMIT, Indices, Singles
from radar_service.plan.cost_model import engine_statistics
from radar_service.plan.plan import NOTHING_KNOWN, Plan, plan_for
from radar_service.plan.statistics import EngineStatistics
from radar_service.receive import receiver_noise_power
from radar_service.records import (
    Crossing,
    Fidelity,
    PowersOf,
    Readings,
    ShipStates,
    Snapshot,
    Spoke,
    SpokeBlock,
    Truth,
    source_request,
)
from radar_service.scans import Sector
from radar_service.scene_file.error_tables import changed_errors
from radar_service.simulation.engine_set_up import SourceTiles, SourceTruth, check_arguments, chosen_fidelity, engine_set_up
from radar_service.simulation.spoke_stream import SpokeStream
from radar_service.simulation.tile_processes import TileProcesses
from radar_service.sources.numbers import source_names
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
        steering = Steering(scene)
        self.scene, self.seed, self.fidelity = scene, seed, chosen_fidelity(scene, fidelity)
        self._threads, self._ends = threads, sector
        self._made = engine_set_up(steering.scene, self.fidelity, fidelity, seed)
        self.range, self.range_step = self._made.engine.range, scene.radar.range_step
        self.noise_power = receiver_noise_power(scene.radar)
        request = source_request(labels, powers)
        engine, _, line_of_sight, pulses = self._made
        if steering.past is not steering.scene:
            line_of_sight = line_of_sight.following(steering.past.bodies, steering.past.revision)
        self._truth = GroundTruth(steering.past, line_of_sight, self.fidelity.sampler)
        self._sources = SourceTruth(steering, self.fidelity, fidelity, self.seed, pulses)
        reporter = ErrorReporter(
            self.scene.radar,
            self.seed,
            self.scene.errors,
            self.scene.radar_id,
            ship=self.scene.platform.body,
            stream=self.scene.environment.stream,
        )
        tiles = SourceTiles(engine, pulses, request)
        self.sources = tiles.sources(source_names(self.scene))
        self.sources.check(request)
        self._processes = TileProcesses(tiles, steering, self._threads)
        self._stream = SpokeStream(self._processes, steering, Sector(self.scene.radar, self._ends), reporter)
        if commands := tuple(commands):
            self.replay(commands)

    def __repr__(self) -> str:
        name, fidelity, scan = self.scene.name, self.fidelity.name, self._stream.next_scan
        return f"<Simulator of {name!r}: fidelity {fidelity}, seed {self.seed}, next is scan {scan}>"

    @cached_property
    @BLAS_LIMIT.held()
    def plan(self) -> Plan:
        """What is modelled and what is not, why, at what error and cost; costs are measured at the first access."""
        if self._made.set_up is None:
            return plan_for(self.scene, self.fidelity)
        return plan_for(self.scene, self.fidelity, engine_statistics(self._made.set_up))

    @property
    def info(self) -> SpokeSourceInfo:
        """What is known of it before its first spoke, its plan included."""
        return self.described(self.plan.as_dict())

    @property
    def unmeasured_info(self) -> SpokeSourceInfo:
        """`info` with a plan without counts and costs, which take a second to measure."""
        culled = NOTHING_KNOWN.culled if self._made.set_up is None else self._made.set_up.culled
        return self.described(plan_for(self.scene, self.fidelity, EngineStatistics(culled)).as_dict())

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
        return self._processes.numbers

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
        return self._stream.reported(number)

    def spokes(self, scans: int | None = None) -> Iterator[Spoke]:
        """The spokes of the next `scans` scans one by one, in order; None: without end."""
        for block in self.blocks(scans):
            yield from block.spokes()

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        """Consecutive spokes from the next scan on, in blocks that never span two scans.

        scans: how many, None: without end; a scan counts as taken with its first block. size: spokes per block (the last of a
        scan may be shorter); it changes no byte.
        """
        return self._stream.blocks(scans, size)

    def feed(self, scans: int | None = None) -> Iterator[Spoke]:
        """The spokes of the next `scans` scans as a client of the service receives them, with the errors of the feed.

        Spokes that are late at the end of the last scan come with the next call. None: without end.
        """
        for block in self.blocks(scans):
            for sent in self._stream.reporter.sent(block):
                yield from sent.spokes()

    def set_errors(self, tables: Mapping[str, Any] | None) -> None:
        """Changes errors on purpose, from the first spoke that was not yet yielded.

        tables: those of `[errors]` in a scene file; each replaces the one in force, and None switches it off. None for all
        switches all off. Raises SceneError.
        """
        errors = changed_errors(self._stream.reporter.errors, tables, self.scene.has_sensors)
        self._stream.reporter.set(errors, self._stream.next_spoke)

    @property
    def errors(self) -> ErrorSettings | None:
        """The errors on purpose of the spokes to come."""
        return self._stream.reporter.errors

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
        self._stream.request_sources(request, spoke)

    @BLAS_LIMIT.held()
    def source_powers(self, scan: int | None = None) -> dict[int, Singles]:
        """The power (A, N) [W] of each source alone in a scan, by source number; by default in the scan that was taken last.

        Noise is its mean, speckle as drawn. A source without power is left out. The scan is computed again, and each source
        compressed by itself. Raises ValueError for the fidelity `documented`.
        """
        return self._sources.powers(self._latest(scan))

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one, counted from 0 at t = 0."""
        self._stream.skip_to(scan)

    def command(
        self, body: str | None = None, *, spoke: int | None = None, time: float | None = None, **values: Any
    ) -> Command:
        """Steers own ship (None) or a body that the scene declares steerable; returns the command with its spoke and time.

        values: as the fields of `Command`, such as course_deg=90. spoke: the first one that shows it, by default the first one
        after the blocks taken so far. time: at which it acts [s], instead of a spoke: the first one not before it shows it.
        With an earlier one, a running `blocks` goes back there, and repeats spokes. May be called from any thread. Raises
        CommandError, and then nothing changes.
        """
        return self._stream.command(body, spoke, time, values)

    def take(self, command: Command) -> None:
        """Takes a command that was made for this scene, by another simulator of it. It acts as one of `command`."""
        self._stream.take(command)

    @property
    def commands(self) -> tuple[Command, ...]:
        """All commands so far, by time: with them another simulator of the same scene makes the same bytes."""
        return self._stream.steering.commands

    def replay(self, commands: Iterable[Command | Mapping[str, Any]]) -> None:
        """Replaces all commands by those of another run, as `commands` gives them or as plain data. Call it between blocks.

        Raises CommandError, and then nothing changes.
        """
        self._stream.steering.replay([each if isinstance(each, Command) else command_from(each) for each in commands])

    def at_rpm(self, rpm: float) -> "Simulator":
        """Returns a simulator of the same scene at another rate of rotation, next the first scan after those of this one.

        Simulated time, positions, commands and errors go on; scans and spokes are counted as if the antenna had always turned at
        that rate. Raises SceneError where the rate leaves no pulse for a spoke.
        """
        scene, request = scene_at_rpm(replace(self.scene, errors=self.errors), rpm), self._stream.request
        commands = [scene.steerable.seen(each, each.body) for each in self.commands]
        sim = Simulator(
            scene, self.fidelity, self.seed, self._threads, self._ends, commands, request.labels, powers=request.powers
        )
        sim.skip_to(scene.radar.first_scan(self.scene.radar.time_of_turns(float(self._stream.next_scan))))
        return sim

    def truth(self, t: float) -> Truth:
        """State of own ship and of every body at time t [s]. Safe to call from another thread."""
        return self._truth.at(t)

    def ship_states(self, times: Sequence[float], names: Sequence[str | None] = (None,)) -> list[ShipStates]:
        """True states of ships at times [s], as commanded then: of bodies by name, of own ship for None; what a radar sees of
        them does not count. Safe to call from another thread. Raises KeyError for a name that no body has."""
        return self._stream.steering.past.ship_states(times, names)

    def crossings(self, scan: int | None = None, radiometric: bool = False, count: int = 1) -> tuple[Crossing, ...]:
        """The truth of each time that the boresight met a body in so many scans, by time; by default in the one taken last.

        A body near north may be crossed twice in a scan, or not at all. radiometric: whether to measure the power of each body
        too, for which the engine computes the azimuths about it again. Safe to call from another thread. Raises ValueError
        where radiometric truth is asked of the fidelity `documented`.
        """
        crossings = self._crossings.crossings(self._latest(scan), count)
        if crossings and self._stream.reporter.has_errors:
            of_each = zip(*((each.own_ship, each.scan, each.spoke) for each in crossings), strict=True)
            reported = self._stream.with_reports(*of_each)
            crossings = tuple(replace(each, own_ship=own) for each, own in zip(crossings, reported, strict=True))
        return self._measured(crossings) if radiometric else crossings

    def snapshot(self, scan: int | None = None) -> Snapshot:
        """The truth of all bodies at the end of a scan, by default of the scan that was taken last."""
        snapshot = self._crossings.snapshot(number := self._latest(scan))
        last = self._stream.reporter.last_spoke(number)
        (own_ship,) = self._stream.with_reports([snapshot.own_ship], [number], [last])
        return replace(snapshot, own_ship=own_ship, feed_errors=self._stream.reporter.counts(number))

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
        self._processes.close()

    @cached_property
    def _crossings(self) -> CrossingTruth:
        """Made when it is first asked: most runs need none."""
        return CrossingTruth(self._truth)

    def _latest(self, scan: int | None) -> int:
        return max(0, self._stream.next_scan - 1) if scan is None else scan

    @BLAS_LIMIT.held()
    def _measured(self, crossings: tuple[Crossing, ...]) -> tuple[Crossing, ...]:
        """The crossings with their radiometric part."""
        return self._sources.measured(crossings)
