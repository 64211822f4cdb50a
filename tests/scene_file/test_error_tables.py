"""Tables of errors: into SI units and back, profiles, where each may stand, and changes."""

import math
from typing import Any, get_args

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.error_tables import PROFILES, changed_errors, drawn_biases, error_tables
from radar_service.scene_file.model.errors import ErrorsModel
from radar_service.world.reporting import ErrorSettings
from tests.world.test_world import EVERY, settings

DEGREE, KNOT = 0.017453292519943295, 1852 / 3600
BOTH = settings({"gyro": {"bias_deg": 1, "noise_deg": 0.1}, "log": {"bias_kn": 1}})


def test_tables_come_back_as_they_were_written() -> None:
    assert error_tables(settings(EVERY)) == EVERY
    assert error_tables(settings({"log": {"bias_kn": 1}})) == {
        "log": {
            "bias_kn": 1.0,
            "scale_percent": 0.0,
            "least_kn": 0.0,
            "noise_kn": 0.0,
            "noise_time_s": 1.0,
            "latency_s": 0.0,
        },
        **dict.fromkeys(("gyro", "position", "antenna", "feed")),
    }


def test_what_is_given_goes_before_the_profile() -> None:
    errors = settings({"profile": "imo-a823", "gyro": {"bias_deg": 2}})
    assert errors.gyro and errors.log and errors.gyro.bias == pytest.approx(math.radians(2), rel=1e-12)
    assert errors.gyro.noise == pytest.approx(math.radians(0.12), rel=1e-12) and errors.log.bias > 0


@pytest.mark.parametrize("errors", [{}, {"gyro": {}}, {"gyro": {"bias_deg": 0}, "feed": {"drop_rate": 0}}])
def test_tables_of_defaults_are_no_errors(errors: dict[str, Any]) -> None:
    assert rs.load_scene({"errors": errors}).errors is None and rs.load_scene({"name": "none"}).errors is None


def test_each_profile_can_be_chosen() -> None:
    names, _ = get_args(ErrorsModel.model_fields["profile"].annotation)
    assert set(get_args(names)) == set(PROFILES)


def test_the_arpa_resolution_gives_these_sensor_errors() -> None:
    """A.823(19), appendix 3: gyro 0.5 degrees, sigma 0.12; log 0.5 knots, 3 sigma 0.2; backlash 0.05, steps 0.2, encoder 0.03."""
    errors = rs.load_scene({"errors": {"profile": "imo-a823"}}).errors
    assert errors is not None and errors.gyro is not None and errors.log is not None and errors.antenna is not None
    assert (errors.gyro.bias, errors.gyro.noise) == pytest.approx((0.5 * DEGREE, 0.12 * DEGREE), rel=1e-12)
    assert (errors.log.bias, 3 * errors.log.noise) == pytest.approx((0.5 * KNOT, 0.2 * KNOT), rel=1e-12)
    antenna = errors.antenna.backlash, errors.antenna.encoder_step, errors.antenna.encoder_noise
    assert antenna == pytest.approx((0.05 * DEGREE, 2 * 0.1 * DEGREE, 0.03 * DEGREE), rel=1e-12)
    assert errors.position is None and errors.feed is None


def test_carriage_rules_since_2004_give_these_sensor_errors() -> None:
    """The log errs by 0.2 knots or 2 %; 95 % of positions are within 13 m, a Rayleigh distribution."""
    errors = rs.load_scene({"errors": {"profile": "imo-2004"}}).errors
    assert errors is not None and errors.log is not None and errors.position is not None and errors.gyro is not None
    assert (errors.log.bias, errors.log.scale, errors.log.least) == pytest.approx((0.0, 0.02, 0.2 * KNOT), rel=1e-12)
    assert 1.0 - math.exp(-0.5 * (13.0 / errors.position.noise) ** 2) == pytest.approx(0.95, rel=1e-12)
    assert (errors.gyro.bias, errors.gyro.noise) == pytest.approx((0.5 * DEGREE, 0.12 * DEGREE), rel=1e-12)


def test_biases_have_signs_and_directions_of_their_own() -> None:
    """400 draws: half of the signs are above 0 within 4 standard errors, 0.1; gyro and log are independent."""
    tables = {"profile": "imo-2004", "position": {"bias_m": [30.0, 40.0]}, "gyro": {"calibration_deg": 0.3}}
    drawn = [drawn_biases(tables, np.random.default_rng(seed)) for seed in range(400)]
    gyro, log = (
        np.array([one[name][key] for one in drawn]) for name, key in (("gyro", "bias_deg"), ("log", "scale_percent"))
    )
    assert set(gyro.tolist()) == {-0.5, 0.5} and set(log.tolist()) == {-2.0, 2.0}
    for signs in (gyro > 0.0, log > 0.0, gyro * log > 0.0):
        assert np.mean(signs) == pytest.approx(0.5, abs=0.1)
    position = np.array([one["position"]["bias_m"] for one in drawn])
    assert np.hypot(*position.T) == pytest.approx(50.0) and np.hypot(*position.mean(axis=0)) < 50.0 * 0.2
    assert np.ptp([one["gyro"]["calibration_phase_deg"] for one in drawn]) > 340.0
    assert settings(drawn[0]).log is not None and drawn[0]["gyro"]["noise_deg"] == 0.12
    assert drawn_biases({"feed": {"drop_rate": 0.1}}, np.random.default_rng(1)) == {"feed": {"drop_rate": 0.1}}


SHORE: dict[str, Any] = {"id": "shore", "platform": {"position_m": [90, 0]}}
FERRY: dict[str, Any] = {"name": "ferry", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9,
                         "position_m": [0, 900, 0]}  # fmt: skip


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
        ({"body": [FERRY | {"errors": {"antenna": {}}}]}, "body[0].errors: antenna belongs to a radar; give it in"),
        ({"body": [FERRY | {"errors": {"log": {}}}]}, 'body[0].errors: "ferry" carries no radar; remove errors'),
        ({"radar": [SHORE], "own_ship": {"errors": {"log": {}}}},
         "own_ship.errors: own ship carries no radar; remove errors"),
        ({"own_ship": {"body": "ferry", "errors": {}}, "body": [FERRY | {"errors": {}}]},
         "own_ship.errors: body[0].errors defines the errors of own ship too; remove one of the two"),
        ({"own_ship": {"errors": {"gyro": {"bias_deg": 200}}}}, "own_ship.errors.gyro.bias_deg: 200 is not allowed"),
        ({"radar": {"errors": {"fed": {}}}}, "radar.errors.fed: this is not a known key"),
    ],
)  # fmt: skip
def test_a_table_at_the_wrong_place_is_refused_with_the_right_one(sections: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene(sections)
    assert message in str(refused.value)


def test_a_table_is_replaced_whole_and_the_others_stay() -> None:
    made = changed_errors(BOTH, {"gyro": {"bias_deg": 2}})
    assert made == settings({"gyro": {"bias_deg": 2}, "log": {"bias_kn": 1}})
    assert changed_errors(None, EVERY) == settings(EVERY) == changed_errors(BOTH, error_tables(settings(EVERY)))


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
