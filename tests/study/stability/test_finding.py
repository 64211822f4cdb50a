"""Crossings and bisections, by which the studies find their boundaries."""

import numpy as np
import pytest

from radar_service.study.stability.finding import bisect, crossing


def test_crossings_and_bisections() -> None:
    parameter = np.array([1.0, 10.0, 100.0])
    assert crossing(parameter, np.array([0.0, 1.0, 2.0]), 0.5) == pytest.approx(5.5)
    assert crossing(parameter, np.array([0.0, 1.0, 2.0]), 0.5, log=True) == pytest.approx(np.sqrt(10.0))
    assert crossing(parameter, np.array([0.0, 1.0, 2.0]), 5.0) is None
    assert crossing(parameter, np.array([3.0, 1.0, 2.0]), 2.5) == 1.0
    assert bisect(lambda x: x < 0.01, 1.0, 1e-9) == pytest.approx(0.01, rel=1e-9)
