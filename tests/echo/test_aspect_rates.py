"""How fast aspects change phases, and which corners count."""

from typing import Any

import numpy as np
import pytest

from radar_service.echo.aspect_rates import AspectRates, waterline_rise
from tests.scenes import scene

BOX = {
    "name": "b",
    "shape": "box",
    "length_m": 20,
    "width_m": 8,
    "height_m": 4,
    "scattering": "optics",
    "position_m": [0, 2000, -1],
}
K = 2.0 * np.pi * 9.41e9 / 299_792_458.0
TIMES = np.arange(-50, 51) * 0.0035 + 100.0


def rates(own_ship: dict[str, Any] | None = None, **body: Any) -> AspectRates:
    """Of a box, each echo of which stands for 0.5 m."""
    made = scene([BOX | body], own_ship=own_ship or {})
    return AspectRates(
        made, made.bodies[0], made.bodies[0].radius, made.bodies[0].diagonal, lambda distance: 0.5, lambda distance: 1.0
    )


def corners(**keys: Any) -> list[int]:
    """The corners among 101 spokes about 100 s."""
    return rates(**keys).corners(TIMES, 100.0).tolist()


def route(after: float, turn_deg: float) -> dict[str, Any]:
    """A course of 5 m/s to the north with a corner at 100 s and some spokes."""
    return {"course_deg": 0, "speed_kn": 10, "manoeuvre": [{"time_s": 100 + (after - 0.5) * 0.0035, "course_deg": turn_deg}]}


def test_jumps_of_the_heading_are_corners_from_a_hundredth_of_a_radian_on() -> None:
    """k 0.5 m x the jump: 0.3 degrees are 0.5 rad at the ends of an echo, 0.01 degrees 0.017 rad."""
    assert corners() == corners(**route(7, 0.01)) == []
    assert corners(**route(7, 0.3)) == corners(**route(7, 90.0)) == [57]
    assert corners(**route(-48, 90.0)) == [2] and corners(**route(48, 90.0)) == [98]
    assert corners(own_ship=route(-20, 90.0) | {"roll_deg": 10}, heading_deg=0) == []


def test_a_corner_of_own_ship_counts_where_it_is_near() -> None:
    """It kinks the bearing by 7 m/s: at 2 km by 0.4 rad/s of phase, at 60 m by 12."""
    near: dict[str, Any] = {"position_m": [0, 560, -1], "heading_deg": 30}
    assert corners(own_ship=route(-20, 90.0), **near) == [30]


def test_a_turn_that_begins_or_ends_is_a_corner() -> None:
    """10 degrees a second turn an echo by 0.3 rad in ten spokes; a thousandth of that is nothing beside 3 degrees a second."""
    turn = {"course_deg": 0, "speed_kn": 10, "manoeuvre": [{"time_s": 100.0, "turn_rate_deg_s": 10}]}
    assert corners(**turn) == [50]
    assert corners(**turn | {"manoeuvre": [{"time_s": 100.0, "turn_rate_deg_s": 0.003}]}) == []
    assert corners(**turn | {"turn_rate_deg_s": 3, "manoeuvre": [{"time_s": 100.0, "turn_rate_deg_s": 3.01}]}) == []


def test_roll_turns_echoes_by_their_height() -> None:
    """Abeam and level with the antenna, k x 1 m x the rate of the roll and half of what it reaches: root of squares."""
    sway = {"roll_deg": 3, "roll_period_s": 5}
    rolling = rates(heading_deg=90, position_m=[0, 2000, 14], **sway).phase_rate(TIMES)
    still = rates(heading_deg=90, position_m=[0, 2000, 14]).phase_rate(TIMES)
    assert still.max() < 1e-9
    swing = np.hypot(np.cos(2 * np.pi * TIMES / 5), 0.5)
    np.testing.assert_allclose(rolling, K * 1.0 * np.deg2rad(3) * 2 * np.pi / 5 * swing, rtol=1e-9)


@pytest.mark.parametrize("sea", [False, True])
def test_a_body_that_passes_turns_by_its_bearing_and_one_that_comes_by_its_reflection(sea: bool) -> None:
    """v / R across. Straight on, the ends of a body of radius r turn by v r / R^2, over the sea by 2 h v / R^2 beside, where R is
    the distance of the nearest part."""

    def rate(course: float) -> tuple[float, float]:
        made = scene(
            [BOX | {"course_deg": course, "speed_kn": 20, "position_m": [0, 1000, 15]}], environment={"multipath": sea}
        )
        body = made.bodies[0]
        each = AspectRates(made, body, body.radius, body.diagonal, lambda distance: 0.5, lambda distance: 1.0)
        return float(each.phase_rate(np.arange(4) * 0.01)[0]), body.radius

    (across, radius), (on, _) = rate(90.0), rate(180.0)
    per_second = K * 0.5 * 20 * 1852 / 3600 / (1000.0 - radius)
    assert across == pytest.approx(per_second, rel=1e-3)
    assert on == pytest.approx(per_second * (radius / 1000 + (2 * 15 / (1000 - radius) if sea else 0.0)), rel=1e-3)


def test_a_waterline_rises_by_heave_and_by_what_roll_lifts_a_side() -> None:
    """2 pi amplitude / period each: a box 8 m wide lifts its side at 4 m; one that never touches the sea has no waterline."""
    box = {"name": "b", "shape": "box", "length_m": 20, "width_m": 8, "height_m": 4, "scattering": "optics"}
    sway = {"heave_m": 0.5, "heave_period_s": 4, "roll_deg": 3, "roll_period_s": 5}
    afloat, aloft = scene([box | sway | {"name": str(up), "position_m": [0, 300, up]} for up in (-1, 50)]).bodies
    expected = 2 * np.pi * (0.5 / 4 + 4 * np.deg2rad(3) / 5)
    assert afloat.motion.sway is not None
    rates = afloat.motion.sway.max_rates[:, None]
    np.testing.assert_allclose(waterline_rise(afloat, rates), expected, rtol=1e-12)
    assert waterline_rise(aloft, rates) == 0.0
