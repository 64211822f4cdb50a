"""Errors of plots on purpose."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.plot_errors import with_errors
from radar_service.bench.scenario import PlotErrors
from tests.bench.scores.test_scoring import truth
from tests.bench.trackers.test_stone_soup import plot


def test_plots_of_points_err_as_the_scenario_says_and_those_of_hulls_do_not() -> None:
    """Standard deviations of 400 plots are within 4 standard errors, 3.5 % each; each seed and scan has its own."""
    errors, exact = PlotErrors(range_sd_m=5.0, bearing_sd_deg=0.2), plot(1.0, 3000.0, 4000.0)
    point = replace(truth("t", 1.0, 3000.0, 4000.0, speed=0.0), position=(3000.0, 4000.0))
    moved = [with_errors([exact], [point], errors, 1, scan)[0] for scan in range(400)]
    assert np.std([one.range - 5000.0 for one in moved]) == pytest.approx(5.0, rel=4 * 0.0354)
    assert np.std([np.degrees(one.bearing - exact.bearing) for one in moved]) == pytest.approx(0.2, rel=4 * 0.0354)
    assert all(np.hypot(one.east, one.north) == pytest.approx(one.range) for one in moved)
    assert with_errors([exact], [point], errors, 2, 0) != with_errors([exact], [point], errors, 1, 0)
    assert (
        with_errors([exact], [replace(point, length=100.0)], errors, 1, 0)
        == (exact,)
        == with_errors([exact], [], None, 1, 0)
    )
