"""Targets of the Signal K Radar API: the truth of bodies in sight, marked as such; by REST, and by the stream each second."""

import math
from dataclasses import replace

import pytest
from pyproj import Geod

from radar_service.ports.signalk.values import MAX_TARGETS, Values, target_path, targets_of
from radar_service.records.truth import BodyTruth, Truth
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from tests.ports.signalk.playing import BASE, heard, playing, until

OWN = BodyTruth("own ship", (0, 0, 0), (0, 5, 0), 0.0, 0.0, 5.0, 0, 0, 0, True, "", 54.0, 8.0, None, 0.0)
ABEAM = BodyTruth(  # 1 km to the east, crossing to the west
    "ferry", (1000, 0, 0), (-5, 0, 0), 4.7, 1.5 * math.pi, 5.0, 1000.4, 0.5 * math.pi, 0, True, "", 54.0, 8.1, None, 40.0
)


def test_a_body_in_sight_is_a_target() -> None:
    """Both make 5 m/s: the line of approach is at 45 degrees, so the distance is 1000 / sqrt 2 m after 100 s."""
    (target,) = targets_of(Truth(0.0, OWN, (ABEAM,))).values()
    danger = target.pop("danger")
    assert (danger["cpa"], danger["tcpa"]) == (pytest.approx(1000 / math.sqrt(2), rel=1e-12), pytest.approx(100, rel=1e-12))
    assert target == {
        "id": 1, "name": "TRUTH ferry", "status": "tracking", "acquisition": "auto",
        "position": {"bearing": 0.5 * math.pi, "distance": 1000, "latitude": 54.0, "longitude": 8.1},
        "motion": {"course": 1.5 * math.pi, "speed": 5.0},
    }  # fmt: skip


def test_what_is_not_known_is_left_out() -> None:
    """A scene without origin has no latitudes; between bodies with one velocity there is no closest approach."""
    beside = replace(ABEAM, velocity=OWN.velocity, latitude_deg=None, longitude_deg=None)
    (target,) = targets_of(Truth(0.0, OWN, (beside,))).values()
    assert "danger" not in target and target["position"].keys() == {"bearing", "distance"}


def test_a_body_keeps_its_number_and_bodies_out_of_sight_are_none() -> None:
    hidden = replace(ABEAM, visible=False, reason="shadowed")
    assert targets_of(Truth(0.0, OWN, (hidden, ABEAM))).keys() == {2}
    assert max(targets_of(Truth(0.0, OWN, (ABEAM,) * (MAX_TARGETS + 9)))) == MAX_TARGETS


def test_positions_are_those_of_the_truth() -> None:
    scene = load_scene(
        {
            "origin": {"latitude_deg": 50, "longitude_deg": -1}, "own_ship": {"speed_kn": 9, "course_deg": 40},
            "body": [
                {"name": "b", "shape": "point", "rcs_dbsm": 9, "position_m": [-900, 400, 4], "speed_kn": 20, "course_deg": 300}
            ],
        }
    )  # fmt: skip
    truth = Simulator(scene, fidelity="fast").truth(70.0)
    target = targets_of(truth)[1]
    east, north = (body - own for body, own in zip(truth.bodies[0].position[:2], truth.own_ship.position[:2], strict=True))
    assert target["position"]["bearing"] == pytest.approx(math.atan2(east, north) % (2 * math.pi), abs=1e-9)
    height = scene.radar.height - 4
    assert target["position"]["distance"] == round(math.hypot(east, north, height))
    assert target["motion"] == {"course": pytest.approx(math.radians(300)), "speed": pytest.approx(20 * 1852 / 3600)}


def test_bearings_count_from_true_north() -> None:
    """Far from the origin's meridian the map's north is another: at 50 N, 200 km to the east, by some 2 degrees."""
    own, body = replace(OWN, position=(200e3, 0, 0)), replace(ABEAM, position=(201e3, 0, 0))
    origin = (50.0, -1.0)
    target = targets_of(Truth(0.0, own, (body,)), origin)[1]
    geod = Geod(ellps="WGS84")
    ends = [geod.fwd(-1.0, 50.0, 90.0, distance)[:2] for distance in (200e3, 201e3)]
    bearing_deg = geod.inv(*ends[0], *ends[1])[0]
    assert math.degrees(target["position"]["bearing"]) == pytest.approx(bearing_deg, abs=1e-3)  # of 2 degrees
    assert bearing_deg - 90.0 > 2.0 and target["motion"]["course"] == pytest.approx(
        math.radians(bearing_deg + 180.0), abs=2e-4
    )


def test_a_target_that_has_gone_becomes_null_once() -> None:
    changed = list[tuple[str, str]]()
    values = Values(changed.append, lambda: "now")
    values.put_targets("sim-1", {1: {"id": 1}, 12: {"id": 12}})
    values.put_targets("sim-12", {1: {"id": 1}})
    values.put_targets("sim-1", {12: {"id": 12}})
    values.put_targets("sim-1", {12: {"id": 12}})
    gone = target_path("sim-1", 1)
    assert changed == [gone, target_path("sim-1", 12), target_path("sim-12", 1), gone]
    assert values[gone] is None and gone not in values.paths
    assert values.targets("sim-1") == [{"id": 12}] and values.targets("sim-12") == [{"id": 1}]


async def test_clients_get_targets_where_they_are_told() -> None:
    async with playing(tells_truth=True) as server:
        socket = await server.open("/signalk/v1/stream?subscribe=none")
        await heard(socket)
        await socket.say(text='{"subscribe": [{"path": "radars.*.targets.*", "policy": "instant"}]}')
        target = await until(socket, "radars.sim-0.targets.1")
        assert target["name"] == "TRUTH buoy" and (await server.http.get(f"{BASE}/sim-0/targets")).json() == [target]
        assert (await server.http.get(f"{BASE}/sim-9/targets")).status_code == 404
        for method, path in (("POST", "targets"), ("DELETE", "targets/1")):
            assert (await server.http.request(method, f"{BASE}/sim-0/{path}", json={})).status_code == 501


async def test_no_truth_is_told_unasked() -> None:
    async with playing() as server:
        socket = await server.open("/signalk/v1/stream")
        await heard(socket)
        seen = set[str]()
        while "navigation.headingTrue" not in seen:
            seen |= {row["path"] for update in (await heard(socket))["updates"] for row in update["values"]}
        assert not any(".targets." in path for path in seen)
        assert (await server.http.get(f"{BASE}/sim-0/targets")).status_code == 501
