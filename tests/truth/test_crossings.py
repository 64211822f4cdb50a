"""The truth of crossings: recomputed from what the scene says alone, late in a run, while own ship and bodies turn and sway."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.truth.crossings import closest_approach
from tests.scenes import point, scene

KNOT = 1852.0 / 3600.0
RADAR = {"azimuths": 360, "beamwidth_deg": 4, "range_max_m": 6000, "rpm": 24, "height_m": 15}
TURN = 2 * math.pi
HULL = {"name": "hull", "shape": "hull", "length_m": 60, "beam_m": 12, "height_m": 8, "rcs_dbsm": 30}


def crossing(sim: rs.Simulator, body: str, scan: int) -> rs.Crossing:
    (found,) = (c for c in sim.crossings(scan) if c.body == body)
    return found


def simulator(bodies: list[dict[str, Any]], **sections: Any) -> rs.Simulator:
    return rs.Simulator(scene(bodies, **{"radar": RADAR} | sections), "fast")


@pytest.mark.parametrize("scan", [0, 1, 997])
def test_straight_courses_by_hand(scan: int) -> None:
    """Own ship steers 030 at 12 kn with a heading of 040; the target 300 at 20 kn. Tolerance: rounding, but where it is named."""
    sim = simulator(
        [point("t", 2000 + 0.2 * scan, 1500, 4, course_deg=300, speed_kn=20, mmsi=235000001)],
        own_ship={"position_m": [100, -200], "course_deg": 30, "speed_kn": 12, "heading_deg": 40},
    )
    c = crossing(sim, "t", scan)
    own = np.array([100, -200]) + 12 * KNOT * c.time * np.array([math.sin(math.radians(30)), math.cos(math.radians(30))])
    speed = 20 * KNOT * np.array([math.sin(math.radians(300)), math.cos(math.radians(300))])
    target = np.array([2000 + 0.2 * scan, 1500]) + speed * c.time
    east, north = target - own
    assert c.position == pytest.approx((*target, 4), abs=1e-6)
    assert c.velocity == pytest.approx((*speed, 0), abs=1e-12)
    assert c.bearing == pytest.approx(math.atan2(east, north) % TURN, abs=1e-9)
    assert c.bearing == pytest.approx(TURN * c.time / 2.5 % TURN, abs=1e-9)  # the boresight at 24 rpm
    assert c.relative_bearing == pytest.approx((c.bearing - math.radians(40)) % TURN, abs=1e-9)
    assert c.aspect == pytest.approx((c.bearing + math.pi - math.radians(300)) % TURN, abs=1e-9)
    distance = math.hypot(east, north)
    up = 4 - 15 - distance**2 / (2 * 4 / 3 * 6_371_000)
    assert c.range == pytest.approx(math.hypot(distance, up), abs=1e-3)  # to the radius of the earth, 0.02 %
    assert c.elevation == pytest.approx(math.atan2(up, distance), abs=1e-6)
    assert (c.course, c.heading) == pytest.approx((math.radians(300), math.radians(300)))
    assert (c.speed, c.turn_rate, c.length, c.beam, c.mmsi) == (pytest.approx(20 * KNOT), 0, 0, 0, 235000001)
    assert (c.scan, c.spoke, c.radar) == (scan, round(c.time / 2.5 * 360), "0")
    assert scan * 2.5 <= c.time < (scan + 1) * 2.5
    assert c.own_ship.position == pytest.approx((*own, 0), abs=1e-6)
    assert (c.own_ship.heading, c.own_ship.course) == pytest.approx((math.radians(40), math.radians(30)))
    assert (c.own_ship.roll, c.own_ship.pitch, c.own_ship.yaw, c.own_ship.reported) == (0, 0, 0, None)
    assert c.latitude_deg is None and c.longitude_deg is None


def test_closest_approach_by_sampling() -> None:
    rng = np.random.default_rng(3)
    offset, velocity = rng.uniform(-1000, 1000, (50, 3)), rng.uniform(-10, 10, (50, 3))
    cpa, tcpa = closest_approach(offset, velocity)
    for k in range(50):
        times = tcpa[k] + np.linspace(-5, 5, 1001)
        distances = np.hypot(*(offset[k, :2] + times[:, None] * velocity[k, :2]).T)
        assert distances.argmin() == 500 and distances.min() == pytest.approx(cpa[k])
    still, never = closest_approach(offset[:1], np.zeros((1, 3)))
    assert still[0] == pytest.approx(math.hypot(*offset[0, :2])) and np.isnan(never[0])


def test_a_passed_target_has_a_negative_time_and_one_alongside_none() -> None:
    sim = simulator(
        [point("passed", 500, -300, course_deg=180, speed_kn=10), point("beside", 200, 300, course_deg=0, speed_kn=10)],
        own_ship={"course_deg": 0, "speed_kn": 10},
    )
    passed, beside = crossing(sim, "passed", 3), crossing(sim, "beside", 3)
    assert passed.tcpa is not None and passed.tcpa < 0 and passed.cpa == pytest.approx(500)
    assert beside.tcpa is None and beside.cpa == pytest.approx(math.hypot(200, 300))


SWAYING = {
    "waypoints": [{"position_m": [0, 800], "speed_kn": 14}, {"position_m": [800, 800], "speed_kn": 14}], "turn_radius_m": 300,
    "roll_deg": 6, "roll_period_s": 9, "pitch_deg": 2, "pitch_period_s": 6, "yaw_deg": 3, "yaw_period_s": 11,
}  # fmt: skip


@pytest.mark.parametrize("scan", [2, 30, 44])
def test_what_turns_and_sways_agrees_with_differences(scan: int) -> None:
    """Velocity and turn rate against central differences over 2 ms; tolerance: their error, h^2 / 6 of the third derivative
    (below 0.05 m/s^3 and 0.1 rad/s^3), and rounding of positions over h."""
    route = [{"position_m": [1500, 1200], "speed_kn": 18}, {"position_m": [400, 1900], "speed_kn": 18}]
    sim = simulator([HULL | {"position_m": [1500, 0, 0], "waypoints": route, "turn_radius_m": 250}], own_ship=SWAYING)
    c = crossing(sim, "hull", scan)
    body, own, h = sim.scene.bodies[0], sim.scene.own_ship, 1e-3
    before, now, after = (body.motion.pose(c.time + dt) for dt in (-h, 0.0, h))
    assert c.heading == pytest.approx(float(now.heading[0]))
    assert c.turn_rate == pytest.approx(float((after.heading - before.heading)[0]) / (2 * h), abs=1e-6)
    assert c.velocity == pytest.approx((after.position - before.position)[0] / (2 * h), abs=1e-6)
    antenna = sim.scene.antenna(c.time)[0]
    assert c.bearing == pytest.approx(math.atan2(c.position[0] - antenna[0], c.position[1] - antenna[1]) % TURN, abs=1e-9)
    rates = [float((own.pose(c.time + h).heading - own.pose(c.time - h).heading)[0]) / (2 * h), own.turn_rate(c.time)[0]]
    assert rates[0] == pytest.approx(rates[1], abs=1e-6)
    roll = math.radians(6) * math.sin(TURN * c.time / 9)
    assert c.own_ship.roll == pytest.approx(roll) and c.own_ship.heading == pytest.approx(float(own.pose(c.time).heading[0]))


def test_the_reference_point_of_a_vessel_is_the_middle_of_its_waterline() -> None:
    """A box of steel whose mesh stands beside its origin, turned by 90 degrees while own ship turns; land keeps its position."""
    mesh = {"name": "ship", "shape": "box", "length_m": 40, "width_m": 10, "height_m": 6, "position_m": [1000, 1000, 0]}
    made = scene([mesh | {"material": "steel", "heading_deg": 90}, point("p", 0, 900)], radar=RADAR)
    vertices = made.bodies[0].mesh.vertices + [7.0, 30.0, -2.0]  # type: ignore[union-attr]
    shifted = dataclasses.replace(made.bodies[0].mesh, vertices=vertices)  # type: ignore[type-var]
    ship = dataclasses.replace(made.bodies[0], mesh=shifted, is_vessel=True)
    land = dataclasses.replace(ship, name="land", is_vessel=False)
    sim = rs.Simulator(made.with_world(bodies=(ship, land)), "fast")
    assert crossing(sim, "ship", 0).position == pytest.approx((1000 + 30, 1000 - 7, 0))  # bow to the east, starboard south
    assert crossing(sim, "land", 0).position == pytest.approx((1000, 1000, 0))


def test_visibility_is_that_of_the_instant() -> None:
    """A ship passes before a buoy: the reason at each crossing is that of the truth at its time."""
    ship = {"name": "ship", "shape": "box", "length_m": 80, "width_m": 20, "height_m": 40, "material": "steel",
            "position_m": [-100, 500, 0], "course_deg": 90, "speed_kn": 10, "rcs_dbsm": 30}  # fmt: skip
    sim = simulator([ship, point("buoy", 0, 1000, 5), point("far", 9000, 0)])
    reasons = []
    for scan in range(20):
        buoy = crossing(sim, "buoy", scan)
        reasons.append(buoy.reason)
        expected = {body.name: body.reason for body in sim.truth(buoy.time).bodies}
        assert buoy.reason == expected["buoy"] and buoy.visible == (not buoy.reason)
        assert crossing(sim, "far", scan).reason == "beyond range"
    assert set(reasons) == {"", "shadowed"} and reasons[0] == reasons[-1] == ""


def test_positions_on_the_earth() -> None:
    """One minute of latitude is 1853 m at 50 degrees (WGS 84: 1111.9 m per hundredth of a degree, to 0.1 m)."""
    sim = simulator([point("t", 0, 1112.3, 5)], origin={"latitude_deg": 50.0, "longitude_deg": -1.0})
    c = crossing(sim, "t", 0)
    assert c.latitude_deg == pytest.approx(50.01, abs=1e-5) and c.longitude_deg == pytest.approx(-1.0, abs=1e-9)


def test_a_snapshot_has_all_bodies_at_the_end_of_the_scan() -> None:
    sim = simulator([point("a", 0, 900, course_deg=90, speed_kn=10), point("b", 0, -900)])
    snapshot = sim.snapshot(3)
    assert (snapshot.scan, snapshot.time, snapshot.radar) == (3, 10.0, "0")
    assert [body.body for body in snapshot.bodies] == ["a", "b"] and {body.time for body in snapshot.bodies} == {10.0}
    assert snapshot.bodies[0].position[0] == pytest.approx(10 * KNOT * 10.0)


@pytest.mark.same_bytes
def test_the_scan_is_by_default_the_one_that_was_taken_last() -> None:
    assert simulator([]).crossings() == () == simulator([]).snapshot().bodies
    sim = simulator([point("t", 900, 0)])
    assert sim.crossings() == sim.crossings(0)
    sim.scan()
    assert sim.crossings() == sim.crossings(0) and sim.snapshot() == sim.snapshot(0)
    sim.scan()
    assert sim.crossings() == sim.crossings(1) and sim.crossings(1) != sim.crossings(0)
