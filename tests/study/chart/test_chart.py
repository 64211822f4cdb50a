"""Charts of scenes."""

import pytest

import radar_service as rs
from radar_service.study.chart import chart
from tests.scenes import scene
from tests.study.chart.settings import SMALL


def test_a_scene_with_nothing_in_sight_is_refused() -> None:
    with pytest.raises(rs.SceneError, match="add a body in sight"):
        chart.measure(scene([], radar=SMALL), effort=chart.QUICK)
