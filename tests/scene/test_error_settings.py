"""Errors in SI units: from tables and back."""

import math
from typing import Any

import pytest

import radar_service as rs
from radar_service.scene.error_settings import ErrorSettings

EVERY: dict[str, dict[str, Any]] = {
    "gyro": {"bias_deg": 0.5, "calibration_deg": 0.3, "calibration_phase_deg": 40.0, "noise_deg": 0.12, "noise_time_s": 7.0,
             "latency_s": 0.2},
    "log": {"bias_kn": -0.5, "scale_percent": 3.0, "noise_kn": 0.1, "noise_time_s": 5.0, "latency_s": 1.0},
    "position": {"bias_m": [3.0, -4.0], "noise_m": 2.5, "noise_time_s": 90.0, "latency_s": 0.5},
    "antenna": {"misalignment_deg": -1.1, "backlash_deg": 0.05, "encoder_noise_deg": 0.03, "encoder_step_deg": 0.2},
    "feed": {"drop_rate": 0.1, "burst_rate": 0.01, "burst_spokes": 12, "repeat_rate": 0.05, "late_rate": 0.04, "late_s": 0.3,
             "swap_rate": 0.02, "stuck_sector_deg": [10.0, 20.0], "heading_lost_s": [[1.0, 2.0], [5.0, 6.0]],
             "bytes_per_s": 5000.0, "cut_after_s": 30.0},
}  # fmt: skip


def settings(errors: Any) -> ErrorSettings:
    """The errors of a scene with these tables."""
    made = rs.load_scene({"errors": errors}).errors
    assert made is not None
    return made


def test_values_become_si_and_radians() -> None:
    its = settings(EVERY)
    assert its.gyro and its.log and its.position and its.antenna and its.feed
    assert its.gyro.calibration_phase == pytest.approx(math.radians(40), rel=1e-12)
    assert (its.log.bias, its.log.scale) == pytest.approx((-0.5 * 1852 / 3600, 0.03), rel=1e-12)
    assert its.position.bias == (3.0, -4.0) and its.antenna.misalignment == pytest.approx(math.radians(-1.1), rel=1e-12)
    assert its.feed.stuck_sector == pytest.approx((math.radians(10), math.radians(20)), rel=1e-12)
    assert (its.feed.bytes, its.feed.cut_after, its.feed.late) == (5000.0, 30.0, 0.3)


def test_tables_come_back_as_they_were_written() -> None:
    assert settings(EVERY).as_tables() == EVERY
    assert settings({"log": {"bias_kn": 1}}).as_tables() == {
        "log": {"bias_kn": 1.0, "scale_percent": 0.0, "noise_kn": 0.0, "noise_time_s": 1.0, "latency_s": 0.0},
        **dict.fromkeys(("gyro", "position", "antenna", "feed")),
    }


def test_what_is_given_goes_before_the_profile() -> None:
    its = settings({"profile": "imo-a823", "gyro": {"bias_deg": 2}})
    assert its.gyro and its.log and its.gyro.bias == pytest.approx(math.radians(2), rel=1e-12)
    assert its.gyro.noise == pytest.approx(math.radians(0.12), rel=1e-12) and its.log.bias > 0


@pytest.mark.parametrize("errors", [{}, {"gyro": {}}, {"gyro": {"bias_deg": 0}, "feed": {"drop_rate": 0}}])
def test_tables_of_defaults_are_no_errors(errors: dict[str, Any]) -> None:
    assert rs.load_scene({"errors": errors}).errors is None and rs.load_scene({"name": "none"}).errors is None


SHORE: dict[str, Any] = {"id": "shore", "platform": {"position_m": [90, 0]}}
FERRY: dict[str, Any] = {
    "name": "ferry",
    "shape": "box",
    "length_m": 9,
    "width_m": 9,
    "height_m": 9,
    "position_m": [0, 900, 0],
}


def of_each(**sections: Any) -> dict[str, ErrorSettings | None]:
    """The errors of the radars of a scene with one on own ship, one on the ferry and one ashore, by their ids.

    ferry, shore: errors of the ferry and of the radar ashore.
    """
    ferry, shore = (({"errors": sections.pop(name)} if name in sections else {}) for name in ("ferry", "shore"))
    radars = [{"id": "bow"}, {"id": "ferry", "platform": {"body": "ferry"}}, SHORE | shore]
    made = rs.load_scene({"radar": radars, "body": [FERRY | ferry], **sections})
    return {name: made.for_radar(name).errors for name in made.radar_ids}


def test_sensors_err_on_their_own_platform_alone() -> None:
    gyro = {"gyro": {"bias_deg": 1}}
    assert of_each(own_ship={"errors": gyro}) == {"bow": settings(gyro), "ferry": None, "shore": None}
    assert of_each(ferry=gyro) == {"bow": None, "ferry": settings(gyro), "shore": None}


def test_antenna_and_feed_err_on_their_own_radar_alone() -> None:
    feed = {"feed": {"drop_rate": 0.1}, "antenna": {"misalignment_deg": 2}}
    assert of_each(shore=feed) == {"bow": None, "ferry": None, "shore": settings(feed)}
    alone = rs.load_scene({"radar": {"errors": feed}, "own_ship": {"errors": {"log": {"bias_kn": 1}}}}).errors
    assert alone == settings(feed | {"log": {"bias_kn": 1}})


def test_errors_of_all_spare_a_fixed_site_those_of_sensors_that_it_lacks() -> None:
    feed = {"feed": {"drop_rate": 0.1}}
    made = of_each(errors={"gyro": {"bias_deg": 1}, "log": {"bias_kn": 1}, "position": {"noise_m": 1}, **feed})
    assert made["bow"] == made["ferry"] != made["shore"] == settings(feed)
    assert of_each(errors={"gyro": {"bias_deg": 1}})["shore"] is None


def test_the_nearest_table_goes_first_key_by_key() -> None:
    """A profile stands for the keys that its own table does not give, so a near profile goes before a far key."""
    gyro = {"bias_deg": 1, "noise_deg": 3}
    made = of_each(errors={"gyro": gyro}, own_ship={"errors": {"gyro": {"bias_deg": 2}}}, ferry={"profile": "imo-a823"})
    assert made["bow"] == settings({"gyro": {"bias_deg": 2, "noise_deg": 3}})
    assert made["ferry"] == settings(
        {"gyro": {"bias_deg": 0.5, "noise_deg": 0.12}, "log": {"bias_kn": 0.5, "noise_kn": 0.2 / 3}}
    )
    assert of_each(errors={"gyro": {"bias_deg": 1}}, own_ship={"errors": {"gyro": {"bias_deg": 0}}})["bow"] is None


def test_a_body_that_is_own_ship_has_its_errors_at_either_place() -> None:
    gyro = {"gyro": {"bias_deg": 1}}
    for sections in ({"own_ship": {"body": "ferry", "errors": gyro}}, {"own_ship": {"body": "ferry"}, "ferry": gyro}):
        assert of_each(**sections) == {"bow": settings(gyro), "ferry": settings(gyro), "shore": None}


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        ({"radar": {"errors": {"gyro": {}}}}, "radar.errors: gyro is a sensor of the platform; give it in"),
        ({"own_ship": {"errors": {"feed": {}}}}, "own_ship.errors: feed belongs to a radar; give it in"),
        (
            {"body": [FERRY | {"errors": {"antenna": {}}}]},
            "body[0].errors: antenna belongs to a radar; give it in",
        ),
        ({"body": [FERRY | {"errors": {"log": {}}}]}, 'body[0].errors: "ferry" carries no radar; remove errors'),
        (
            {"radar": [SHORE], "own_ship": {"errors": {"log": {}}}},
            "own_ship.errors: own ship carries no radar; remove errors",
        ),
        (
            {"own_ship": {"body": "ferry", "errors": {}}, "body": [FERRY | {"errors": {}}]},
            "own_ship.errors: body[0].errors defines the errors of own ship too; remove one of the two",
        ),
        ({"own_ship": {"errors": {"gyro": {"bias_deg": 200}}}}, "own_ship.errors.gyro.bias_deg: 200 is not allowed"),
        ({"radar": {"errors": {"fed": {}}}}, "radar.errors.fed: this is not a known key"),
    ],
)
def test_a_table_at_the_wrong_place_is_refused_with_the_right_one(sections: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene(sections)
    assert message in str(refused.value)
