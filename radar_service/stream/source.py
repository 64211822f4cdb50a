"""What the stream needs of a running scene, so that tests and recordings can replace one, and how it orders one."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from radar_service.cell_sources import SourceList, SourceRequest
from radar_service.display.video import Layout, layout
from radar_service.fidelity import Fidelity
from radar_service.radar.parameters import FIRST_ID, Origin, Radar
from radar_service.records import SpokeBlock, Truth
from radar_service.scene.commands import Command, CommandLog, Steerable
from radar_service.scene.error import SceneError
from radar_service.scene.error_settings import ErrorSettings


@dataclass(frozen=True)
class SceneOrder:
    """Names a scene, so that another process can load it.

    source: a file, the name of a packaged scene, or a small scene itself.
    sandboxed: whether its meshes and height maps are parsed in a process of their own, see scene.files.sandbox.
    rpm: rate of rotation instead of the scene's own.
    origin: where it goes on at that rate; None for a scene that begins, or whose origin is not agreed yet.
    radar: id of one of the scene's radars, None for the first.
    plan: as plain data, where it was made for this order before; it is not made again.
    folder: kept while this order exists; it owns the files of an upload.
    """

    source: str | Path | Mapping[str, Any]
    sandboxed: bool = False
    rpm: float | None = None
    origin: Origin | None = None
    radar: str | None = None
    plan: Mapping[str, Any] | None = field(default=None, compare=False, repr=False)
    folder: object = field(default=None, compare=False, repr=False)

    @property
    def goes_on(self) -> bool:
        """Whether it goes on with the time, the commands and the errors of a scene that runs."""
        return self.origin is not None

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"folder": None}  # another process does not own the folder


NOT_STEERABLE = Steerable({}, frozenset(), None)


@dataclass(frozen=True)
class SceneOutline:
    """A scene as the serving process knows it: the bodies and their meshes stay with the process that computes.

    notes: sentences about its files that need no action; whoever uploads the scene gets them.
    steerable: what commands may steer.
    errors: on purpose, which the serving process adds; None without any.
    radar_id: of the radar; radar_ids: of all radars of its file.
    has_sensors: whether the platform has gyro, log and position sensor.
    """

    name: str
    origin: tuple[float, float] | None
    body_count: int
    warnings: tuple[str, ...]
    radar: Radar
    notes: tuple[str, ...] = ()
    steerable: Steerable = NOT_STEERABLE
    errors: ErrorSettings | None = None
    radar_id: str = FIRST_ID
    radar_ids: tuple[str, ...] = (FIRST_ID,)
    has_sensors: bool = True

    def at_origin(self, origin: Origin) -> "SceneOutline":
        """Returns the outline with another origin of the radar's rotation."""
        radar = replace(self.radar, origin=origin)
        return replace(self, radar=radar, steerable=replace(self.steerable, radar=radar))


def other_radars(given: Sequence[str], here: Sequence[str | None]) -> SceneError:
    """Returns the error for a scene with the ids of other radars than its world has here."""
    return SceneError(
        f"radar: the scene has {', '.join(given)}, but {', '.join(map(str, here))} runs here; give a scene with the same radars, "
        "or start the server with this one"
    )


class PlanSummary(Protocol):
    """A plan, as far as the stream is concerned."""

    def as_dict(self) -> dict[str, Any]:
        """The plan as plain data."""


class TruthLine(NamedTuple):
    """A line of the truth stream: JSON, and the simulated time [s] that it is of."""

    time: float
    text: str


class SpokeSource(Protocol):
    """Produces the spokes of one scene. `radio.world.WorldSource` is one."""

    @property
    def order(self) -> SceneOrder:
        """What it was made from; another one can be made from it."""

    @property
    def scene(self) -> SceneOutline:
        """The scene that it simulates."""

    @property
    def seed(self) -> int:
        """The seed of its random generators."""

    @property
    def fidelity(self) -> Fidelity:
        """The settings of its calculation."""

    @property
    def plan(self) -> PlanSummary:
        """What it models and what it does not."""

    @property
    def noise_power(self) -> float:
        """Thermal noise of a range cell [W], whether or not noise is on."""

    @property
    def range(self) -> NDArray[np.float64]:
        """Ranges of the samples (N,) [m]."""

    @property
    def range_step(self) -> float:
        """Distance from sample to sample [m]."""

    @property
    def trees(self) -> int:
        """Number of its trees for ray tests, as of a second ago; 0 before its first block."""

    def blocks(self, *, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields blocks of at most `size` consecutive spokes of one scan each, without end."""

    def begin_at(self, origin: Origin) -> None:
        """Lets the scene go on from an origin, at the rate of its order. Comes before `replay` and `blocks`."""

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one, counted from 0."""

    @property
    def commands(self) -> CommandLog:
        """All commands to its world so far."""

    def command(self, command: Command) -> None:
        """Takes a command that was made for its world (`CommandLog.made`). `tell` comes next.

        Blocks that do not follow it may still come, and then all spokes from its own on come again: `SpokeBlock.commands` says
        how many commands a block knows. Waits for nothing.
        """

    def tell(self) -> None:
        """Tells commands to what computes, which may take its time. From any thread."""

    def replay(self, commands: Iterable[Command]) -> None:
        """Takes all commands of another source of the same scene. Comes before `blocks`."""

    @property
    def sources(self) -> SourceList:
        """The sources of its cells, and what its spokes can tell of them."""

    def request_sources(self, request: SourceRequest, spoke: int | None) -> None:
        """Changes what spokes tell of their sources, from a spoke on, which is not taken yet; None: the next one computed.

        Blocks that do not follow it may still come, and then all spokes from that one on come again: `SpokeBlock.requests` says
        how many requests a block follows. From any thread. Does nothing where spokes always tell them.
        """

    def truth(self, t: float) -> Truth:
        """Returns the state of own ship and of every body at time t [s]."""

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> "list[TruthLine]":
        """Returns the truth of the beam crossings of a scan, and of its end; the header for None. Raises EngineFault.

        radiometric: whether crossings have the power of each body too.
        """

    def spare(self) -> "SpokeSource | None":
        """Returns another source of the same scene that is ready at once; None where there is none."""

    def close(self) -> None:
        """Ends the computation, from any thread; `blocks` and `truth` then fail."""


class Progress(Protocol):
    """Is told how far a preparation is, and can end it. in_background: whether the feed of a radar comes first."""

    @property
    def in_background(self) -> bool: ...

    def stage(self, text: str) -> None:
        """Notes what is being done now."""

    def ends_with(self, close: Callable[[], None]) -> None:
        """Notes what to call where the preparation is to end early."""


class NoProgress:
    """A preparation that nobody follows or ends, because a radar waits for it."""

    in_background = False

    def stage(self, text: str) -> None:
        """Ignores it."""

    def ends_with(self, close: Callable[[], None]) -> None:
        """Ignores it."""


UNFOLLOWED = NoProgress()
MakeSource = Callable[[SceneOrder, Progress], SpokeSource]


def cell_layout(source: SpokeSource, bins: int | None, range_max: float | None) -> Layout:
    """Returns how this source's range cells become `bins` bins out to range_max [m]; None stands for all."""
    return layout(source.range.size, float(source.range[0]), source.range_step, bins, range_max)
