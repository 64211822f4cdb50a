"""How fast shadows move over a body, in closed form."""

import numpy as np
import pytest

from radar_service.echo.shadow_rates import STEADY, ShadowRates
from radar_service.scattering.model import Caster
from tests.scenes import scene

KNOT = 1852.0 / 3600.0
HULL = {"shape": "box", "scattering": "optics", "length_m": 6.0, "width_m": 3.0, "height_m": 2.0, "heading_deg": 0}
TIME = np.array([10.0, 10.1, 10.2])
SIZE = float(np.sqrt(6.0**2 + 3.0**2 + 2.0**2))


def rates(target: dict[str, object], other: dict[str, object], **own: object) -> ShadowRates:
    made = scene(
        [{"name": "target", **HULL, **target}, {"name": "other", **HULL, **other}], own_ship={"position_m": [0, 0], **own}
    )
    return ShadowRates(made, made.bodies[0])


def test_a_shadow_moves_as_many_times_faster_as_it_falls_farther_off() -> None:
    """A hull at 500 m that crosses at 10 kn moves its shadow at 20 kn over a body at 1000 m."""
    sideways = {"position_m": [-10.0 * KNOT * 10.1, 500.0, 0.0], "speed_kn": 10.0, "course_deg": 90.0}
    shadow = rates({"position_m": [0.0, 1000.0, 0.0]}, sideways)
    assert shadow.rate([Caster(1, 500.0)], TIME)[1] == pytest.approx(
        20.0 * KNOT / (STEADY * SIZE), rel=1e-3
    )  # straight course
    assert shadow.moving([1], TIME) == [1]


def test_a_shadow_rests_where_both_keep_one_bearing() -> None:
    """A body at 1000 m and one at 500 m that cross at 10 and 5 kn."""
    both = [
        {"position_m": [-speed * KNOT * 10.1, north, 0.0], "speed_kn": speed, "course_deg": 90.0}
        for speed, north in ((10.0, 1000.0), (5.0, 500.0))
    ]
    assert rates(*both).rate([Caster(1, 500.0)], TIME)[1] < 0.001 * 10.0 * KNOT / (STEADY * SIZE)


def test_own_ship_moves_shadows_of_what_rests() -> None:
    """At 10 kn across, the shadow of what stands half way moves at 10 kn over what rests."""
    shadow = rates({"position_m": [0.0, 1000.0, 0.0]}, {"position_m": [0.0, 500.0, 0.0]}, speed_kn=10.0, course_deg=90.0)
    assert shadow.rate([Caster(1, 500.0)], TIME)[1] == pytest.approx(
        10.0 * KNOT / (STEADY * SIZE), rel=1e-2
    )  # 52 m aside by then


def test_what_rests_moves_no_shadow_over_what_rests() -> None:
    shadow = rates({"position_m": [0.0, 1000.0, 0.0]}, {"position_m": [0.0, 500.0, 0.0]})
    assert not shadow.rate([Caster(1, 500.0)], TIME).any() and shadow.moving([1], TIME) == []
