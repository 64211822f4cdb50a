"""The settings of a radar by REST: transmission, display range, display controls, pace."""

import math
from dataclasses import dataclass, field
from typing import Any, Literal

from radar_service.display.video import Controls


@dataclass(frozen=True)
class Pace:
    """Run or pause, and simulated seconds per second; a factor of inf is as fast as possible.

    Raises ValueError for a factor that is not above 0.
    """

    state: Literal["run", "pause"] = "run"
    factor: float = 1.0

    def __post_init__(self) -> None:
        if not self.factor > 0:
            raise ValueError(f'pace.factor: {self.factor:g} is not above 0; give a number, or "max"')

    def as_dict(self) -> dict[str, Any]:
        """Returns the pace as plain data, as REST and the feed give it."""
        return {"state": self.state, "factor": "max" if math.isinf(self.factor) else self.factor}


@dataclass(frozen=True)
class Settings:
    """Settings of one radar. range: of the display [m], None for the radar's whole range."""

    transmit: bool = True
    range: float | None = None
    video: Controls = field(default_factory=Controls)
    pace: Pace = field(default_factory=Pace)
