"""How the stream requests the scenes that it sends, and what they are made by."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from radar_service.display.video import Layout, layout
from radar_service.processes.call import Progress
from radar_service.spoke_source import Commanded, SpokeSource, SpokeSourceInfo, TellsShips, TellsSources

if TYPE_CHECKING:
    from radar_service.world import Scene


@dataclass(frozen=True)
class SceneRequest:
    """Names a scene, so that another process can load it.

    scene_input: a file, the name of a packaged scene, or a small scene itself.
    sandboxed: whether its meshes and height maps are parsed in a process of their own, see scene_file.readers.sandbox.
    rpm: rate of rotation instead of the scene's own.
    range_m: range scale of a set that is sold instead of the scene's own.
    goes_on: whether it goes on with the time, the commands and the errors of a scene that runs.
    radar: id of one of the scene's radars, None for the first.
    plan: as plain data, where it was made for this scene request before; it is not made again.
    blind: whether clients are told neither the seed nor the number of bodies.
    measured_later: whether its first spokes come before the counts and costs of its plan.
    folder: kept while this scene request exists; it owns the files of an upload.
    """

    scene_input: str | Path | Mapping[str, Any]
    sandboxed: bool = False
    rpm: float | None = None
    range_m: float | None = None
    goes_on: bool = False
    radar: str | None = None
    plan: Mapping[str, Any] | None = field(default=None, compare=False, repr=False)
    blind: bool = False
    measured_later: bool = field(default=False, compare=False)
    folder: object = field(default=None, compare=False, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"folder": None}  # another process does not own the folder


class SceneSpokeSource(SpokeSource, Protocol):
    """A source of spokes of which another one can be made. `radio.scene_process.SceneProcess` is one."""

    @property
    def scene_request(self) -> SceneRequest:
        """What it was made from."""


@runtime_checkable
class Spared(Protocol):
    """A source in a process of its own, with another process that stands by.

    trees: number of its trees for ray tests, as of a second ago; 0 before its first block.
    """

    trees: int

    def spare(self) -> SceneSpokeSource | None:
        """Returns another source of the same scene that is ready at once; None where there is none."""


class ProcessSimulator(SpokeSource, Commanded, TellsSources, TellsShips, Protocol):
    """What computes in the process of a scene: a `Simulator`."""

    @property
    def trees(self) -> int:
        """Number of trees for ray tests."""

    @property
    def unmeasured_info(self) -> SpokeSourceInfo:
        """Returns `info` with a plan that has no counts and costs yet."""

    def described(self, plan: Mapping[str, Any]) -> SpokeSourceInfo:
        """Returns `info` with a plan that was made before."""

    def set_errors(self, tables: Mapping[str, Any] | None) -> None:
        """Changes errors on purpose."""


MakeSpokeSource = Callable[[SceneRequest, Progress], SceneSpokeSource]
MakeSimulator = Callable[["Scene"], ProcessSimulator]


def cell_layout(info: SpokeSourceInfo, bins: int | None, range_max: float | None) -> Layout:
    """Returns how this source's range cells become `bins` bins out to range_max [m]; None stands for all."""
    return layout(info.range.size, float(info.range[0]), info.range_step, bins, range_max, info.radar.pulses_integrated)
