"""What a world process needs of an engine, and what it tells the serving process about it."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from radar_service.cell_sources import PowersOf, SourceList
from radar_service.fidelity import Fidelity
from radar_service.radar.parameters import Origin
from radar_service.records import Crossing, Snapshot, SpokeBlock, Truth
from radar_service.scene.commands import Command
from radar_service.scene.world import Scene
from radar_service.stream.source import PlanSummary, SceneOutline


class SceneEngine(Protocol):
    """Computes the spokes of one scene. `Simulator` is one; see there."""

    scene: Scene
    seed: int
    fidelity: Fidelity
    noise_power: float
    range: NDArray[np.float64]
    range_step: float
    sources: SourceList

    @property
    def plan(self) -> PlanSummary:
        """What it models and what it does not."""

    @property
    def trees(self) -> int:
        """Number of trees for ray tests."""

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields blocks of spokes."""

    def begin_at(self, origin: Origin) -> None:
        """Lets the rotation begin at another origin, before all commands and spokes."""

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one."""

    def take(self, command: Command) -> None:
        """Takes a command that was made for its world."""

    def replay(self, commands: Iterable[Command]) -> None:
        """Replaces all commands."""

    def set_errors(self, tables: Mapping[str, Any] | None) -> None:
        """Changes errors on purpose."""

    def request_sources(self, labels: bool = False, powers: PowersOf = (), spoke: int | None = None) -> None:
        """Changes what spokes tell of their sources."""

    def truth(self, t: float) -> Truth:
        """Returns the truth at time t [s]."""

    def crossings(self, scan: int | None = None, radiometric: bool = False) -> tuple[Crossing, ...]:
        """Returns the beam crossings of a scan; radiometric: with the power of each body."""

    def snapshot(self, scan: int | None = None) -> Snapshot:
        """Returns the truth at the end of a scan."""

    def truth_header(self) -> dict[str, Any]:
        """Returns what a stream of the truth says first."""


MakeEngine = Callable[[Scene], SceneEngine]


@dataclass(frozen=True)
class Description:
    """All that the serving process knows of the engine of a scene, see source.SpokeSource."""

    scene: SceneOutline
    seed: int
    fidelity: Fidelity
    plan: dict[str, Any]
    noise_power: float
    range: NDArray[np.float64]
    range_step: float
    sources: SourceList
