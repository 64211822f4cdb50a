"""A feed while strangers attack the service: pytest -m bench -s tests/measurements/test_strangers.py takes three minutes and
prints the figures; `python -m tests.measurements.strangers` takes a quarter of an hour."""

import os

import pytest

from tests.measurements import strangers

pytestmark = pytest.mark.bench


@pytest.fixture(autouse=True)
def _asked_for(request: pytest.FixtureRequest) -> None:
    if "bench" not in str(request.config.option.markexpr):
        pytest.skip("opt-in: -m bench")


def test_strangers_stop_no_feed() -> None:
    print(f"\nload average {os.getloadavg()[0]:.1f}")
    assert strangers.main(["--attack", "15", "--rest", "5", "--runs", "4"]) == 0
