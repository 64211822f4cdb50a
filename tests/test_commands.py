"""Commands in whole runs: they act from their spoke on, change nothing before, and replay to the same bytes."""

import json
import math
import threading
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine.preparation import prepare
from radar_service.numerics.constants import KNOT
from radar_service.plan.culling import cull
from radar_service.records.fidelity import fidelity_from_name
from radar_service.world.commands import Command
from radar_service.world.steered_motion import SteeredMotion, SteeringLimits
from radar_service.world.steering import with_motions
from tests.scenes import everything, point, scene

AZIMUTHS = 72
STEERED = {"max_speed_kn": 25, "max_turn_rate_deg_s": 6}
RunControl = Mapping[int, tuple[str | None, dict[str, Any]]]  # by the spoke after which they are given
ORDERS: RunControl = {
    20: ("steel", {"course_deg": 160, "speed_kn": 20}),
    75: (None, {"speed_kn": 15, "turn_rate_deg_s": 5}),
    100: ("buoy", {"position_m": [-150, 200], "heading_deg": 40}),
    131: ("wood", {"course_deg": 10, "at_once": True}),
    150: ("steel", {"speed_kn": 0}),
    151: ("buoy", {"present": False}),
    190: ("buoy", {"present": True, "position_m": [200, 150]}),
}
LIGHT = scene(
    [
        point("steel", 100, 300, steerable=STEERED),
        point("buoy", -200, 100, steerable=STEERED, swerling=1),
        {"name": "wood", "shape": "box", "length_m": 9, "width_m": 30, "height_m": 6, "position_m": [100, 150, 0],
         "material": "wood", "steerable": STEERED},
        {"name": "quay", "shape": "box", "length_m": 9, "width_m": 90, "height_m": 6, "position_m": [100, 400, 0],
         "material": "concrete"},
    ],
    radar={"azimuths": AZIMUTHS, "beamwidth_deg": 8, "range_max_m": 600, "pulse_s": 1e-6},
    environment={"noise": True, "sea_state": 3},
    own_ship={"steerable": STEERED},
)  # fmt: skip
SMALL_RADAR = {"azimuths": AZIMUTHS, "range_max_m": 600, "beamwidth_deg": 8}
ONE = scene([point("a", 0, 300, steerable=STEERED)], radar=SMALL_RADAR)


def steerable_everything() -> rs.Scene:
    """The scene of all effects, with everything but the quay steerable."""
    made, limits = everything(), SteeringLimits(25 * KNOT, math.radians(6.0))
    bodies = {body.name: SteeredMotion.under(body.motion, limits) for body in made.bodies if body.name != "quay"}
    return with_motions(made, {**bodies, None: SteeredMotion.under(made.own_ship, limits)})


def power(sim: rs.Simulator, scans: int = 3, size: int = 16, orders: RunControl | None = None) -> bytes:
    """The bytes of some scans, during which orders are given."""
    made = []
    for block in sim.blocks(scans, size=size):
        for spoke in block.spokes():
            made.append(
                spoke.power.tobytes() + np.array([*spoke.position, spoke.heading, spoke.course, spoke.speed]).tobytes()
            )
            if orders and spoke.number in orders:
                body, values = orders[spoke.number]
                sim.command(body, **values)
    return b"".join(made)


def differing(one: bytes, other: bytes, scans: int = 3) -> list[int]:
    """The numbers of the spokes that differ."""
    count = AZIMUTHS * scans
    size = len(one) // count
    return [n for n in range(count) if one[n * size : (n + 1) * size] != other[n * size : (n + 1) * size]]


@pytest.mark.parametrize("fidelity", ["fast", "documented"])
def test_a_run_with_commands_replays_to_the_same_bytes(fidelity: str) -> None:
    made = steerable_everything()
    plain = power(rs.Simulator(made, fidelity, 3), 1)
    live = rs.Simulator(made, fidelity, 3)
    steered = power(live, orders=ORDERS)
    first = live.commands[0].spoke
    assert first == 32 and differing(plain, steered[: len(plain)], 1)[0] >= first  # 20 lies in the block that ends with 31
    recorded = json.loads(json.dumps([command.as_dict() for command in live.commands]))
    replayed = rs.Simulator(made, fidelity, 3, commands=recorded)
    assert power(replayed) == steered
    assert replayed.commands == live.commands


def test_grouping_and_threads_change_no_byte() -> None:
    live = rs.Simulator(LIGHT, "fast", 3)
    steered = power(live, orders=ORDERS)
    assert power(rs.Simulator(LIGHT, "fast", 3, 3), orders=ORDERS) == steered
    assert power(rs.Simulator(LIGHT, "fast", 3, commands=live.commands), size=7) == steered
    assert power(rs.Simulator(LIGHT, "fast", 3, 3, commands=live.commands), size=50) == steered
    live.skip_to(0)
    assert power(live) == steered
    live.skip_to(2)
    assert power(live, 1) == steered[len(steered) // 3 * 2 :]


def test_spokes_before_a_command_do_not_change_and_those_after_it_do() -> None:
    made = scene(
        [point("a", 0, 300, steerable=STEERED)],
        radar={"azimuths": AZIMUTHS, "beamwidth_deg": 30, "range_max_m": 800},
        environment={"noise": True},
    )
    plain = power(rs.Simulator(made, "fast"))
    for spoke in (4, 5, 71):
        command = {"spoke": spoke, "body": "a", "position_m": [0, 500]}
        assert differing(plain, power(rs.Simulator(made, "fast", commands=[command])))[0] == spoke


def test_a_sector_has_the_bytes_of_the_whole_run() -> None:
    live = rs.Simulator(LIGHT, "fast", 3)
    whole = power(live, orders=ORDERS)
    size = len(whole) // (3 * AZIMUTHS)
    sector = rs.Simulator(LIGHT, "fast", 3, sector=(0.0, np.pi / 2 - 1e-9), commands=live.commands)
    expected = b"".join(whole[n * size : (n + 1) * size] for n in range(3 * AZIMUTHS) if n % AZIMUTHS < AZIMUTHS // 4)
    assert power(sector) == expected


def test_an_earlier_spoke_takes_the_run_back() -> None:
    sim, numbers, latest = rs.Simulator(LIGHT, "fast", 3), [], {}
    for block in sim.blocks(2):
        numbers.append(block.first)
        latest |= {spoke.number: spoke.power for spoke in block.spokes()}
        if block.first == 104 and not sim.commands:
            sim.command("steel", spoke=70, position_m=[0, 200])
    assert numbers == [0, 16, 32, 48, 64, 72, 88, 104, 70, 72, 88, 104, 120, 136]
    whole = [spoke.power for spoke in rs.Simulator(LIGHT, "fast", 3, commands=sim.commands).spokes(2)]
    assert np.array([latest[n] for n in range(2 * AZIMUTHS)]).tobytes() == np.array(whole).tobytes()


def test_a_point_follows_its_commands_in_range_and_bearing() -> None:
    """The echo against the closed form of the course: 10 m/s to the east from spoke 72 on, 3 scans of 2.5 s."""
    made = scene(
        [point("a", 0, 400, steerable={"max_speed_kn": 40})],
        radar={"azimuths": 360, "beamwidth_deg": 3, "range_max_m": 800, "rpm": 24, "pulse_s": 1e-6},
    )
    command = {"spoke": 360, "body": "a", "course_deg": 90, "at_once": True, "speed_kn": 10 / KNOT}
    sim = rs.Simulator(made, "balanced", commands=[command])
    for _ in range(4):
        scan = sim.scan()
    (crossing,) = sim.crossings()
    elapsed = crossing.time - 2.5
    assert crossing.position[:2] == pytest.approx((10 * elapsed, 400.0), abs=1e-6)
    assert math.degrees(crossing.course) == pytest.approx(90) and crossing.speed == pytest.approx(10)
    row = crossing.spoke - 3 * 360
    peak = scan.range[int(np.argmax(scan.power[row]))]
    assert peak == pytest.approx(crossing.range, abs=scan.range[1] - scan.range[0])
    assert int(np.argmax(scan.power.max(axis=1))) == pytest.approx(row, abs=1)  # rounding of the spoke


def test_it_says_what_it_did_and_the_truth_follows_at_once() -> None:
    sim = rs.Simulator(ONE, "fast")
    for spoke in sim.spokes():
        if spoke.number == 20:
            break
    command = sim.command("a", speed_kn=10, course_deg=90, at_once=True)
    assert command == Command(32, 32 * 2.5 / AZIMUTHS, "a", course_deg=90.0, speed_kn=10.0, at_once=True)
    truth = sim.truth(command.time + 10.0).bodies[0]
    assert truth.position == pytest.approx((100 * KNOT, 300, 15), abs=1e-9)
    assert sim.truth(command.time - 0.1).bodies[0].position == (0.0, 300.0, 15.0)


def test_the_past_stays_in_truth_and_crossings() -> None:
    sim = rs.Simulator(ONE, "fast")
    sim.scan()
    before = sim.crossings(0), sim.snapshot(0), sim.truth(1.0)
    sim.command("a", position_m=[0, 200])
    sim.scan()
    assert (sim.crossings(0), sim.snapshot(0), sim.truth(1.0)) == before
    assert sim.crossings(1)[0].position == (0.0, 200.0, 15.0)


def test_a_moved_ship_shadows_what_is_behind_it_now() -> None:
    size = {"length_m": 4, "width_m": 60, "height_m": 40}
    wall = {"name": "wall", "shape": "box", **size, "position_m": [200, 0, 0], "rcs_dbsm": -40}
    made = scene(
        [{**wall, "steerable": {}}, point("p", 0, 400, 2.0), point("q", 400, 0, 2.0)],
        radar=SMALL_RADAR,
    )
    sim = rs.Simulator(made, "fast")
    sim.scan()
    assert [body.reason for body in sim.truth(2.6).bodies] == ["", "", "shadowed"]
    sim.command("wall", position_m=[0, 200])
    assert [body.reason for body in sim.truth(2.6).bodies] == ["", "shadowed", ""]
    scan = sim.scan()
    assert [body.reason for body in sim.truth(2.6).bodies] == ["", "shadowed", ""]
    assert [body.reason for body in sim.truth(2.4).bodies] == ["", "", "shadowed"]
    cell = int(np.argmin(np.abs(scan.range - 400)))
    at_p, at_q = (scan.power[row, cell - 2 : cell + 3].max() for row in (0, AZIMUTHS // 4))
    assert at_p < 1e-3 * at_q  # all that is left is what two beams 90 degrees apart share


def test_a_body_disappears_and_appears() -> None:
    sim = rs.Simulator(ONE, "fast", commands=[{"spoke": 60, "body": "a", "present": False}])
    cell = int(np.argmin(np.abs(sim.range - 300)))
    scans = [sim.scan() for _ in range(2)]
    sim.command("a", present=True, position_m=[300, 0])
    scans.append(sim.scan())
    north, east = ([float(scan.power[row, cell]) for scan in scans] for row in (0, AZIMUTHS // 4))
    assert north[0] > 0 and north[1] == 0 and east[0] < 1e-3 * north[0] and east[1] == 0
    assert east[2] == pytest.approx(north[0], rel=1e-3)  # spokes point at both
    assert [body.visible for t in (2.0, 3.0, 6.0) for body in sim.truth(t).bodies] == [True, False, True]
    assert [len(sim.crossings(n)) for n in range(3)] == [1, 1, 1]


def test_commands_from_another_thread_lose_no_spoke() -> None:
    sim = rs.Simulator(ONE, "fast")
    started, ended = threading.Event(), threading.Event()

    def steer() -> None:
        started.wait()
        for n in range(50):
            sim.command("a", course_deg=float(7 * n % 360))
        ended.set()

    thread = threading.Thread(target=steer)
    thread.start()
    numbers, live = [], []
    for spoke in sim.spokes(6):
        started.set()
        numbers.append(spoke.number)
        live.append(spoke.power)
    assert ended.wait(60)
    thread.join()
    assert numbers == list(range(6 * AZIMUTHS)) and len(sim.commands) == 50
    replayed = [spoke.power for spoke in rs.Simulator(ONE, "fast", commands=sim.commands).spokes(6)]
    assert np.array(replayed).tobytes() == np.array(live).tobytes()


def test_what_is_steerable_is_prepared_as_moving_and_is_never_culled() -> None:
    bodies = [point("far", 0, 90_000, steerable={}), point("sunk", 0, 300, steerable={}), point("gone", 0, 90_000)]
    made = scene(bodies, radar={"range_max_m": 600}, environment={"noise": True})
    fidelity = replace(fidelity_from_name("fast"), error_db=1.0)
    assert list(cull(made, fidelity)) == [2]
    prepared = prepare(made, fidelity, 0)
    assert [body.name for body in prepared.resting_set.bodies] == ["gone"]
    own = scene([point("gone", 0, 90_000)], radar={"range_max_m": 600}, own_ship={"steerable": {}})
    assert not cull(own, fidelity) and len(prepare(own, fidelity, 0).resting_set) == 0


def test_own_ship_steers_round_a_target_by_what_the_radar_shows() -> None:
    """Each scan the strongest echo is the target; own ship keeps it abeam to starboard, 250 m off, and comes round it."""
    made = scene(
        [point("rock", 30, 330, 15.0, 30.0)],
        radar={"azimuths": 64, "beamwidth_deg": 8, "range_max_m": 600, "pulse_s": 1e-6},
        environment={"noise": True},
        own_ship={"steerable": {"max_speed_kn": 30, "max_turn_rate_deg_s": 10}, "heading_deg": 270, "speed_kn": 0},
    )
    sim = rs.Simulator(made, "fast", 1)
    sim.command(speed_kn=24)
    bearings, ranges = [], []
    for _ in range(70):
        scan = sim.scan()
        azimuth, cell = np.unravel_index(scan.power.argmax(), scan.power.shape)
        bearings.append(scan.azimuth[azimuth])
        ranges.append(scan.range[cell])
        off = np.clip((ranges[-1] - 250.0) / 100.0, -1.0, 1.0)  # rad towards the target
        sim.command(course_deg=float(np.rad2deg(bearings[-1] - np.pi / 2.0 + off) % 360.0))
    turned = np.unwrap(bearings)
    assert turned[-1] - turned[5] > 2.0 * np.pi  # all the way round
    true = [np.hypot(30 - x, 330 - y) for x, y, _ in (sim.truth(t).own_ship.position for t in np.arange(40.0, 170.0, 5.0))]
    assert 190.0 < min(true) and max(true) < 290.0  # inside 250 m: own ship turns late by a scan, 31 m of way, and by a beam
