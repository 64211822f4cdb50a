"""Multiple echoes in scene files: what they become, and what is refused."""

import pytest

import radar_service as rs
from radar_service.stages.multiple_echoes.effect import MultipleEchoes
from tests.scenes import radar


def test_multiple_echoes_in_si_units() -> None:
    table = {"own_rcs_dbsm": 40, "range_m": 600, "orders": 3}
    assert radar(multiple_echoes=table).effects == {"multiple": MultipleEchoes(10_000.0, 600.0, 3)}
    assert radar().effects == {}


def test_orders_and_cross_section_have_limits() -> None:
    with pytest.raises(rs.SceneError, match="radar.multiple_echoes.orders: 5 is not allowed.*1 to 4"):
        radar(multiple_echoes={"own_rcs_dbsm": 40, "orders": 5})
    with pytest.raises(rs.SceneError, match="radar.multiple_echoes.own_rcs_dbsm: missing"):
        radar(multiple_echoes={})
