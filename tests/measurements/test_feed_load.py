"""The feed under load, each row of docs/accuracy.md#load: pytest -m bench tests/measurements/test_feed_load.py -s prints the
figures."""

import os

import pytest

from tests.measurements.load_table import CASES, RATIOS, SECONDS, row

pytestmark = pytest.mark.bench


@pytest.fixture(autouse=True)
def _asked_for(request: pytest.FixtureRequest) -> None:
    if "bench" not in str(request.config.option.markexpr):
        pytest.skip("opt-in: -m bench")


@pytest.mark.parametrize("name", [*CASES, *RATIOS])
def test_load_stays_within_its_limits(name: str) -> None:
    line, faults = row(name, SECONDS)
    print(f"\n{line} load average {os.getloadavg()[0]:.1f}")
    assert not faults
