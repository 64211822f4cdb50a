"""What may be wrong: one number in dB of target power, and what follows from it for fields and for every single knob."""

import math
from dataclasses import dataclass

DEFAULT_DB = 0.5  # of target power
DEFAULT_FIELD_DB = -40.0  # relative field error that goes with it
LEAST_DB, MOST_DB = 0.01, 10.0  # below, single precision is the limit; above, nothing gets any cheaper
WEAKER = 14.0  # dB: a target this much weaker than the rms of its scene still keeps the budget
STEPS_DB = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # tried where time is the budget, the finest, as dense as `reference`, first


@dataclass(frozen=True)
class ErrorBudget:
    """target_db: by how much the mean power of a target may be wrong [dB]. Raises ValueError outside LEAST_DB to MOST_DB."""

    target_db: float = DEFAULT_DB

    def __post_init__(self) -> None:
        if not LEAST_DB <= self.target_db <= MOST_DB:
            raise ValueError(f"error budget: {self.target_db:g} dB is not allowed; {LEAST_DB:g} to {MOST_DB:g} dB")

    @property
    def field_db(self) -> float:
        """Relative field error [dB] allowed: it goes in proportion to the error of powers, as small errors do."""
        return DEFAULT_FIELD_DB + 20.0 * math.log10(self.target_db / DEFAULT_DB)

    @property
    def method_db(self) -> float:
        """Relative field error [dB] allowed to the numerical methods together, over all echoes of a scene."""
        return self.field_db - WEAKER

    @property
    def share(self) -> float:
        """By what share of itself a power may change."""
        return float(10.0 ** (self.target_db / 10.0) - 1.0)
