"""Rules of a scene file that involve several keys."""

import pytest

import radar_service as rs
from tests.scenes import scene


def test_a_period_without_amplitude_is_refused() -> None:
    with pytest.raises(rs.SceneError, match="roll_period_s: it needs an amplitude; add roll_deg"):
        scene([], own_ship={"roll_period_s": 8})
