"""A Simulator of this process as a source of spokes for the stream."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from radar_service.cell_sources import SourceList, SourceRequest
from radar_service.fidelity import Fidelity
from radar_service.radar.parameters import Origin
from radar_service.records import SpokeBlock, Truth
from radar_service.scene.commands import Command, CommandLog
from radar_service.simulator import Simulator
from radar_service.stream.radio.world_process import outline_of, truth_lines
from radar_service.stream.source import PlanSummary, SceneOrder, SceneOutline, TruthLine
from radar_service.types import Floats


@dataclass(eq=False)
class SimulatedSource:
    """A stream.source.SpokeSource: the simulator of the scene that `order` names."""

    simulator: Simulator
    order: SceneOrder

    @property
    def scene(self) -> SceneOutline:
        """As SpokeSource.scene."""
        return outline_of(self.simulator.scene)

    @property
    def plan(self) -> PlanSummary:
        """As SpokeSource.plan."""
        return self.simulator.plan

    @property
    def seed(self) -> int:
        """As SpokeSource.seed."""
        return self.simulator.seed

    @property
    def fidelity(self) -> Fidelity:
        """As SpokeSource.fidelity."""
        return self.simulator.fidelity

    @property
    def noise_power(self) -> float:
        """As SpokeSource.noise_power."""
        return self.simulator.noise_power

    @property
    def range(self) -> Floats:
        """As SpokeSource.range."""
        return self.simulator.range

    @property
    def range_step(self) -> float:
        """As SpokeSource.range_step."""
        return self.simulator.range_step

    @property
    def trees(self) -> int:
        """As SpokeSource.trees."""
        return self.simulator.trees

    def blocks(self, *, size: int = 16) -> Iterator[SpokeBlock]:
        """As SpokeSource.blocks."""
        return self.simulator.blocks(size=size)

    def begin_at(self, origin: Origin) -> None:
        """As SpokeSource.begin_at."""
        self.simulator.begin_at(origin)
        self.order = replace(self.order, origin=origin)

    def skip_to(self, scan: int) -> None:
        """As SpokeSource.skip_to."""
        self.simulator.skip_to(scan)

    @property
    def commands(self) -> CommandLog:
        """As SpokeSource.commands."""
        return CommandLog(self.simulator.scene.steerable, self.simulator.commands)

    def command(self, command: Command) -> None:
        """As SpokeSource.command."""
        self.simulator.take(command)

    def tell(self) -> None:
        """Does nothing: the simulator knows its commands."""

    def replay(self, commands: Iterable[Command]) -> None:
        """As SpokeSource.replay. Raises CommandError."""
        self.simulator.replay(commands)

    @property
    def sources(self) -> SourceList:
        """As SpokeSource.sources."""
        return self.simulator.sources

    def request_sources(self, request: SourceRequest, spoke: int | None) -> None:
        """As SpokeSource.request_sources. Raises ValueError."""
        self.simulator.request_sources(request.labels, request.powers, spoke)

    def truth(self, t: float) -> Truth:
        """As SpokeSource.truth."""
        return self.simulator.truth(t)

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
        """As SpokeSource.truth_lines."""
        return truth_lines(self.simulator, scan, radiometric)

    def spare(self) -> None:
        """Returns None."""

    def close(self) -> None:
        """Does nothing: the simulator computes only when a block is taken."""
