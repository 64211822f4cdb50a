"""How the suite runs: on all cores, except where figures are printed or measured."""

import os

import pytest

SUITE = "not bench and not study"


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Cores for the suite, at most four; none besides this process for benchmarks, studies and with -s or --pdb."""
    alone = config.option.markexpr != SUITE or config.option.capture == "no" or config.option.usepdb
    return 0 if alone else min(4, len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1)
