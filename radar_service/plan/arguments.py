"""Command line options of the plan."""

import argparse
import contextlib
import math

from radar_service.plan.budget import DEFAULT_DB, MAX_DB, MIN_DB, ErrorBudget

ERROR_HELP = f"plan for errors in target power of {MIN_DB:g} to {MAX_DB:g} dB (auto: {DEFAULT_DB:g})"
PACE_HELP = "the most accurate plan, or that of --error-db, that runs so many times real time on one thread here"


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
