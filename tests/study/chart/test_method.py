"""Sample ranges of a method."""

import numpy as np

from radar_service.study.chart.method import Method
from tests.scenes import radar
from tests.study.chart.settings import SMALL


def test_samples_begin_where_the_method_says() -> None:
    """The documented chain samples whole steps, the engine the middles of range bins."""
    small = radar(**SMALL)
    for first in (0.0, 0.5):
        method = Method("family", "setting", lambda echoes, spokes: np.zeros((0, 0), np.complex64), small, first, None)
        assert method.sample_range[0] == first * small.range_step and len(method.sample_range) == small.bins
        np.testing.assert_allclose(np.diff(method.sample_range), small.range_step, rtol=1e-9)
