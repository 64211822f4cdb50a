"""Echoes of points by the radar equation; `tests/plug_ins/effects` holds them against a body that is a point."""

import numpy as np
import pytest

from radar_service.echo.echoes import AzimuthTimes
from radar_service.stages.point_echoes import point_echoes
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import scene
from tests.stages.fixtures import context_of

WALL = {"name": "wall", "shape": "plate", "width_m": 200, "height_m": 80, "position_m": [0, 900, 0]}


def test_points_out_of_range_out_of_sight_and_behind_a_wall_have_no_echoes() -> None:
    """The others have the power of the radar equation (Skolnik 2001, eq. 1.7) on boresight, and the change of their ranges."""
    made = scene([WALL], radar={"range_max_m": 5000})
    line_of_sight = OcclusionScene(made.bodies, 8.5e6)
    context = context_of(made, "hail")._replace(line_of_sight=line_of_sight, echo_sources={"hail": 1})
    azimuths = AzimuthTimes(np.arange(3), np.zeros(3), np.arange(3) * 0.1)
    start = np.array([[0.0, 500, 15], [0, 1500, 15], [0, 4000, 0], [0, 90_000, 15], [0, 600, 15]])
    position = start[:, None] + np.array([0.0, 10.0, 0.0]) * azimuths.time[:, None]
    echoes = point_echoes(context, "hail", azimuths, position, np.array([1.0, 1.0, 1.0, 1.0, 4.0]))
    assert echoes.range == pytest.approx([501.0, 601.0], abs=0.05) and echoes.body.tolist() == [1, 1]
    np.testing.assert_allclose(echoes.range_migration, [[-1.0, 0.0, 1.0]] * 2, atol=1e-3)
    radar = made.radar
    power = radar.power * radar.gain**2 * radar.wavelength**2 / ((4 * np.pi) ** 3 * echoes.range**4 * radar.loss)
    assert np.abs(echoes.amplitude[:, 1]) ** 2 == pytest.approx(power * [1.0, 4.0], rel=1e-3)
