"""Changes by tables: what is replaced, what stays, what is switched off."""

from typing import Any

import pytest

import radar_service as rs
from radar_service.errors.tables import changed_errors
from tests.scene.test_error_settings import EVERY, settings

BOTH = settings({"gyro": {"bias_deg": 1, "noise_deg": 0.1}, "log": {"bias_kn": 1}})


def test_a_table_is_replaced_whole_and_the_others_stay() -> None:
    made = changed_errors(BOTH, {"gyro": {"bias_deg": 2}})
    assert made == settings({"gyro": {"bias_deg": 2}, "log": {"bias_kn": 1}})
    assert changed_errors(None, EVERY) == settings(EVERY) == changed_errors(BOTH, settings(EVERY).as_tables())


@pytest.mark.parametrize("nothing", [None, {}, {"latency_s": 0}])
def test_a_table_is_switched_off(nothing: Any) -> None:
    assert changed_errors(BOTH, {"gyro": nothing}) == settings({"log": {"bias_kn": 1}})
    assert changed_errors(BOTH, {"gyro": nothing, "log": nothing}) is None


def test_none_switches_all_off_and_no_table_changes_nothing() -> None:
    assert changed_errors(BOTH, None) is None and changed_errors(BOTH, {}) == BOTH and changed_errors(None, {}) is None


def test_a_profile_replaces_the_tables_that_it_has() -> None:
    position = settings({"position": {"noise_m": 3}, "gyro": {"latency_s": 1}})
    made = changed_errors(position, {"profile": "imo-a823", "log": {"scale_percent": 2}})
    assert made == settings({"profile": "imo-a823", "log": {"scale_percent": 2}, "position": {"noise_m": 3}})


@pytest.mark.parametrize("tables", [5, "gyro", [1], {"gyro": 1}, {"gyro": {"bias_deg": float("inf")}}, {"gyroscope": {}}])
def test_what_is_not_a_table_is_refused(tables: Any) -> None:
    with pytest.raises(rs.SceneError, match="errors"):
        changed_errors(BOTH, tables)


def test_a_site_without_sensors_has_no_errors_of_them() -> None:
    made = changed_errors(None, {"profile": "imo-a823", "log": None, "position": {}}, has_sensors=False)
    assert made and made.antenna and not (made.gyro or made.log or made.position)
    message = (
        "errors.gyro: a fixed site has no gyro, log or position sensor; remove gyro, or turn the picture by antenna.misalign"
    )
    with pytest.raises(rs.SceneError, match=message):
        changed_errors(None, {"gyro": {"bias_deg": 1}}, has_sensors=False)
