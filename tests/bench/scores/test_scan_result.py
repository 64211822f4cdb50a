"""Truth in the frame that own ship reports, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.scores.scan_result import as_reported, at_end
from tests.bench.scores.test_scoring import truth

OWN = replace(
    truth("t", 0.0, 0.0, 0.0), position=(100.0, 14916.0), velocity=(3.0, -10.0), own_position=(100.0, 100.0),
    own_velocity=(0.0, 5.0),
)  # fmt: skip


def test_half_a_degree_of_gyro_is_129_m_at_8_nm() -> None:
    """To the right of her, as the whole picture is turned to starboard."""
    moved = as_reported(replace(OWN, azimuth_error=np.radians(0.5)))
    assert moved.position[0] - 100.0 == pytest.approx(14816.0 * np.sin(np.radians(0.5))) and moved.position[0] > 229.0
    assert np.hypot(moved.position[0] - 100.0, moved.position[1] - 100.0) == pytest.approx(14816.0)


def test_velocities_turn_relative_to_own_ship() -> None:
    """She is said to move as she does; the target's motion relative to her is turned by 90 degrees."""
    moved = as_reported(replace(OWN, azimuth_error=np.pi / 2.0))
    assert moved.velocity == pytest.approx((-15.0, 5.0 - 3.0))


def test_an_error_of_her_position_moves_all() -> None:
    moved = as_reported(replace(OWN, own_error=(10.0, -4.0)))
    assert moved.position == pytest.approx((110.0, 14912.0)) and moved.velocity == OWN.velocity
    assert as_reported(OWN).position == pytest.approx(OWN.position)


def test_target_and_own_ship_move_on_to_the_end_of_the_scan() -> None:
    moved = at_end(OWN, 2.0)
    assert (moved.time, moved.position, moved.own_position) == (2.0, (106.0, 14896.0), (100.0, 110.0))
