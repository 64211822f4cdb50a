"""The error budget: one number in dB of target power, and the field errors that follow from it."""

import argparse
import contextlib
import math
from dataclasses import dataclass

DEFAULT_DB = 0.5  # of target power
DEFAULT_FIELD_DB = -40.0  # relative field error of the default budget
MIN_DB, MAX_DB = 0.01, 10.0  # below, single precision is the limit; above, no method gets any cheaper
WEAK_TARGET_DB = 14.0  # a target this much weaker than the rms of its scene still keeps the budget
STEPS_DB = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # tried in turn where time is limited; the first is as dense as `reference`
ERROR_HELP = f"plan for errors in target power of {MIN_DB:g} to {MAX_DB:g} dB (auto: {DEFAULT_DB:g})"
PACE_HELP = "the most accurate plan, or that of --error-db, that runs so many times real time on one thread here"


@dataclass(frozen=True)
class ErrorBudget:
    """target_db: allowed error of a target's mean power [dB]. Raises ValueError outside MIN_DB to MAX_DB."""

    target_db: float = DEFAULT_DB

    def __post_init__(self) -> None:
        if not MIN_DB <= self.target_db <= MAX_DB:
            raise ValueError(f"error budget: {self.target_db:g} dB is not allowed; {MIN_DB:g} to {MAX_DB:g} dB")

    @property
    def field_db(self) -> float:
        """Allowed relative field error [dB]. It is proportional to the error of power, as small errors are."""
        return DEFAULT_FIELD_DB + 20.0 * math.log10(self.target_db / DEFAULT_DB)

    @property
    def method_db(self) -> float:
        """Allowed relative field error [dB] of all numerical methods together, over all echoes of a scene."""
        return self.field_db - WEAK_TARGET_DB

    @property
    def share(self) -> float:
        """Allowed relative change of a power."""
        return float(10.0 ** (self.target_db / 10.0) - 1.0)


def error_budget(text: str) -> ErrorBudget:
    """An error budget [dB]. Raises ArgumentTypeError."""
    with contextlib.suppress(ValueError):
        return ErrorBudget(float(text))
    raise argparse.ArgumentTypeError(f'"{text}" is not an error budget; give {MIN_DB:g} to {MAX_DB:g} dB of target power')


def finite_pace(text: str) -> float:
    """Simulated seconds per second, finite. Raises ArgumentTypeError."""
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) < math.inf:
            return float(text)
    raise argparse.ArgumentTypeError(f'"{text}" is not a pace; give a number above 0, 1 is real time')
