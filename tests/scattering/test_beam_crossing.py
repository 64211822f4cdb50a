"""When the beam crosses a body: the instant at which the aspect of a moving body is evaluated."""

import numpy as np
import pytest

from radar_service.scattering.beam_crossing import BeamCrossing
from tests.scenes import point, scene


@pytest.mark.parametrize("time", [1.4, 3.3, 20.1, 100.0])
@pytest.mark.parametrize("bearing_deg", [1.0, 90.0, 200.0, 359.5])
def test_the_boresight_points_at_the_body_then(time: float, bearing_deg: float) -> None:
    """To half a spoke (0.25 degrees), and the body's own motion within one (0.01); never more than half a turn off."""
    b = np.deg2rad(bearing_deg)
    made = scene([point("p", 1000 * np.sin(b), 1000 * np.cos(b), speed_kn=14, course_deg=70)], own_ship={"speed_kn": 9})
    motion = made.bodies[0].motion
    instant = BeamCrossing(made).instant(made.bodies[0], time)
    assert abs(instant - time) <= 1.25 + 1 / 288
    east, north, _ = motion.pose(instant).position[0] - made.antenna(instant)[0]
    boresight = 2 * np.pi * instant / made.radar.rotation_period
    off = (np.arctan2(east, north) - boresight + np.pi) % (2 * np.pi) - np.pi
    assert abs(np.rad2deg(off)) < 0.26


def test_never_before_the_start() -> None:
    made = scene([point("p", -700, 700, speed_kn=10, course_deg=0)])
    assert BeamCrossing(made).instant(made.bodies[0], 0.05) >= 0.0


def test_a_slow_antenna_takes_the_requested_instant() -> None:
    """One turn a minute: half a turn before the crossing, the aspect is that of the requested instant."""
    made = scene([point("p", 0, -1000, speed_kn=10, course_deg=180)], radar={"rpm": 1})
    crossing = BeamCrossing(made)
    assert crossing.instant(made.bodies[0], 5.0) == 5.0
    assert crossing.instant(made.bodies[0], 29.0) == pytest.approx(30.0, abs=0.2)
