"""The kernel of beam weights against numpy."""

import numpy as np
import pytest

from radar_service.echo.moving_beam import BeamTable
from tests.kernels.both import both


@pytest.mark.parametrize(("count", "azimuths"), [(0, 4), (1, 1), (1, 17), (700, 16), (700, 3)])
def test_beam_weights_are_those_of_numpy(count: int, azimuths: int) -> None:
    """Also beyond the table's end, and near enough for the loss to change by a fifth. Bytes are equal."""
    draw, table = np.random.default_rng(18), BeamTable(lambda offset: np.cos(offset) ** 2, 0.03, 0.1, 0.02)
    boresight, azimuth = draw.uniform(-0.02, 0.02, azimuths), draw.uniform(-0.3, 0.3, count)
    changes, migration = draw.uniform(-0.01, 0.01, (count, azimuths)), draw.uniform(-9.0, 9.0, (count, azimuths))
    columns = [c.astype(np.float32) for c in (boresight, azimuth, changes, draw.uniform(0.0, 0.01, count), migration)]
    compiled, by_numpy = both(lambda: table.weights(*columns))
    np.testing.assert_array_equal(compiled, by_numpy)
    assert compiled.dtype == np.float32 and compiled.shape == (count, azimuths)
