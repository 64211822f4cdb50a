"""What the stream needs of a simulator, so that tests and recordings can replace one."""

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from radar_service.display.video import Layout, layout
from radar_service.fidelity import Fidelity
from radar_service.records import SpokeBlock, Truth
from radar_service.scene.world import Scene


class PlanSummary(Protocol):
    """A plan, as far as the stream is concerned."""

    def as_dict(self) -> dict[str, Any]:
        """The plan as plain data."""


class SpokeSource(Protocol):
    """Produces the spokes of one scene. `Simulator` is one."""

    @property
    def scene(self) -> Scene:
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

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields blocks of at most `size` consecutive spokes of one scan each; without end where scans is None."""

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one, counted from 0."""

    def truth(self, t: float) -> Truth:
        """Returns the state of own ship and of every body at time t [s]."""


def cell_layout(source: SpokeSource, bins: int | None, range_max: float | None) -> Layout:
    """Returns how this source's range cells become `bins` bins out to range_max [m]; None stands for all."""
    return layout(source.range.size, float(source.range[0]), source.range_step, bins, range_max)
