"""What produces the spokes of a scene: a simulator, a recording, or the process of a scene. Some can do more than others."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, runtime_checkable

from radar_service.numerics import Floats
from radar_service.radar import Radar
from radar_service.records import Crossing, Fidelity, PowersOf, ShipStates, Snapshot, SourceList, SpokeBlock, Truth
from radar_service.world import Command, SceneOutline


class SpokeSourceFault(Exception):
    """The spoke source failed. The text says why."""


class BusyFault(SpokeSourceFault):
    """The spoke source cannot do it now, but may do so soon: the machine is too busy, or its process is replaced."""


@dataclass(frozen=True, eq=False)
class SpokeSourceInfo:
    """What is known of a source before its first spoke, as data that another process may have.

    seed: of its random generators; fidelity: the settings of its calculation; plan: what it models and what not, as plain data;
    the process of a scene that a server starts with completes its counts and costs in place after the first spokes.
    noise_power: thermal noise of a range cell [W], whether or not noise is on.
    range: (N,) of the samples [m], `range_step` apart.
    sources: of its cells, and what its spokes can tell of them.
    """

    scene: SceneOutline
    seed: int
    fidelity: Fidelity
    plan: Mapping[str, Any]
    noise_power: float
    range: Floats
    range_step: float
    sources: SourceList

    @property
    def radar(self) -> Radar:
        """The radar that turns."""
        return self.scene.radar


class TruthLine(NamedTuple):
    """A line of the truth: JSON, and the simulated time [s] that it is of."""

    time: float
    text: str

    @classmethod
    def of(cls, record: Crossing | Snapshot) -> "TruthLine":
        """Returns the line of a record."""
        return cls.of_content(record.time, record.as_dict())

    @classmethod
    def of_content(cls, time: float, content: Mapping[str, Any]) -> "TruthLine":
        """Returns the line of plain data."""
        return cls(time, json.dumps(content, allow_nan=False))


class SpokeSource(Protocol):
    """Produces the spokes of one scene."""

    @property
    def info(self) -> SpokeSourceInfo:
        """What is known of it before its first spoke."""

    def blocks(self, *, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields blocks of at most `size` consecutive spokes of one scan each."""

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one, counted from 0."""

    def truth(self, t: float) -> Truth:
        """Returns the state of own ship and of every body at time t [s]."""

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
        """Returns the truth of the beam crossings of a scan, and of its end; the header for None.

        radiometric: whether crossings have the power of each body too.
        """

    def close(self) -> None:
        """Ends the computation, from any thread; `blocks` and `truth` then fail."""


@runtime_checkable
class Commanded(Protocol):
    """A source that follows commands."""

    def take(self, command: Command) -> None:
        """Takes a command that was made for its world; from any thread, and it may take its time.

        Blocks that do not follow it may still come, and then all spokes from its own on come again: `SpokeBlock.commands` says
        how many commands a block knows.
        """

    def replay(self, commands: Iterable[Command]) -> None:
        """Takes all commands of another source of the same scene. Comes before `blocks`."""


@runtime_checkable
class TellsShips(Protocol):
    """A source that knows how ships move between its spokes, too."""

    def ship_states(self, times: Sequence[float], names: Sequence[str | None]) -> list[ShipStates]:
        """Returns the true states of ships at times [s], as commanded then: of bodies by name, of own ship for None."""


@runtime_checkable
class TellsSources(Protocol):
    """A source whose spokes tell of the sources of cells what is requested. Others tell what they have."""

    def request_sources(self, labels: bool = False, powers: PowersOf = (), spoke: int | None = None) -> None:
        """Changes what spokes tell of their sources, from a spoke on, which is not taken yet; None: the next one computed.

        Blocks that do not follow it may still come, and then all spokes from that one on come again: `SpokeBlock.requests` says
        how many requests a block follows. From any thread.
        """
