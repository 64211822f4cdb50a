"""The short modules of the Signal K port, each under its name."""

import argparse
import asyncio
import math
import re
import sys
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from fastapi import HTTPException
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Geod

from radar_service.__main__ import main
from radar_service.ports import signalk
from radar_service.ports.ais.transponders import AisReport, Position
from radar_service.ports.nmea.own_ship import OwnShipReport
from radar_service.ports.signalk.codec import SpokeFields, last_spokes, spoke_bytes
from radar_service.ports.signalk.radar_routes import failure, report
from radar_service.ports.signalk.radars import Radars, legend
from radar_service.ports.signalk.signalk_port import POLICY
from radar_service.ports.signalk.subscriptions import SELF
from radar_service.ports.signalk.subscriptions import Path as ValuePath
from radar_service.ports.signalk.values import MAX_TARGETS, Values, own_ship_values, target_path, targets_of, vessel_values
from radar_service.processes.limits import MachineBusyError
from radar_service.records.truth import BodyTruth, Truth
from radar_service.scene_file.load import load_scene
from radar_service.service.access import Access
from radar_service.service.controls import ControlError
from radar_service.service.radio.station import Station
from radar_service.simulator import Simulator
from radar_service.terminal.arguments import UsageError
from radar_service.world.error import SceneError
from radar_service.world.reporting import AisShip
from tests.ports.signalk.playing import BASE, heard, playing, until
from tests.ports.signalk.protobuf import spokes
from tests.service.fake import FakeEngine, factory, scene


# radar_routes: reports of the Signal K API from what is raised for a request.
def test_reports() -> None:
    assert report(200) == {"state": "COMPLETED", "statusCode": 200, "message": "OK"}
    assert report(404, "no") == {"state": "FAILED", "statusCode": 404, "message": "no"}


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (HTTPException(404, "gone"), 404, "gone"), (ControlError("gain: 500"), 400, "gain: 500"),
        (SceneError("scene: bad"), 400, "scene: bad"), (MachineBusyError("later"), 503, "later"),
    ],
)  # fmt: skip
def test_refusals_have_the_statuses_of_the_api(error: Exception, status: int, message: str) -> None:
    assert failure(error) == report(status, message)


def test_what_is_no_refusal_is_raised_again() -> None:
    with pytest.raises(ZeroDivisionError):
        failure(ZeroDivisionError())


# codec: the message of spokes: what the library of Protocol Buffers reads is what was written, for any values.
DEGREES = st.floats(-180.0, 180.0)
SPOKE = st.builds(
    SpokeFields, st.integers(0, 16383), st.none() | st.integers(0, 16383), st.integers(0, 200_000),
    st.none() | st.integers(0, 2**53), st.none() | st.tuples(DEGREES, DEGREES), st.binary(max_size=300),
)  # fmt: skip


@settings(deadline=None)
@given(st.lists(SPOKE, max_size=5))
def test_what_was_written_is_read(written: list[SpokeFields]) -> None:
    read = spokes(b"".join(map(spoke_bytes, written)))
    assert len(read) == len(written)
    for got, spoke in zip(read, written, strict=True):
        assert got.get("angle", 0) == spoke.angle and got.get("range", 0) == spoke.range
        assert got.get("bearing") == spoke.bearing and got.get("time") == spoke.time  # absent where it is not known
        assert got.get("data", b"") == spoke.data
        assert (got.get("lat"), got.get("lon")) == (spoke.position or (None, None))


@settings(deadline=None)
@given(st.lists(SPOKE, min_size=1, max_size=5), st.data())
def test_the_last_spokes_of_a_message(written: list[SpokeFields], data: st.DataObject) -> None:
    count = data.draw(st.integers(0, len(written)))
    whole = list(map(spoke_bytes, written))
    assert last_spokes(b"".join(whole), count) == b"".join(whole[len(whole) - count :])


# radars: radars as the Signal K Radar API lists them: ids that its paths can have, and the colours of the legend.
def test_ids_have_no_dots_and_slashes_and_the_radars_are_found_by_them() -> None:
    """Dots divide the paths of the stream, slashes those of HTTP."""
    stations = {name: Station(name, FakeEngine(scene()), factory()) for name in ("0", "bow.x/1", "ä b")}
    radars = Radars(stations)
    assert [identity for identity, _ in radars] == sorted(["sim-0", "sim-bow-x-1", "sim---b"])
    assert all(
        re.fullmatch("[A-Za-z0-9-]+", identity) and radars.station(identity) is station for identity, station in radars
    )
    assert radars.station("0") is None


def test_the_legend_goes_from_blue_by_green_to_red() -> None:
    """Red, green and blue of each echo add up to full light, to the rounding of three bytes."""
    colours = [[int(pixel["color"][at : at + 2], 16) for at in (1, 3, 5, 7)] for pixel in legend()["pixels"]]
    assert colours[0] == [0, 0, 0, 0] and colours[-1] == [255, 0, 0, 255] and colours[1][2] > 250
    red, green, blue, opacity = zip(*colours[1:], strict=True)
    assert all(abs(sum(each) - 255) <= 1 for each in zip(red, green, blue, strict=True)) and set(opacity) == {255}
    assert list(red) == sorted(red) and list(blue) == sorted(blue, reverse=True) and max(green) > 250


# signalk_port: the port: pages of others under /gui/ with a content policy of their own, and its options.
async def test_a_folder_is_served_with_a_policy_of_its_own(tmp_path: Path) -> None:
    folder = tmp_path / "page"
    (folder / "proto").mkdir(parents=True)
    (folder / "index.html").write_text("the page")
    (folder / "proto" / "x.proto").write_text("a file")
    (tmp_path / "secret").write_text("not of the page")
    async with playing(gui=folder, access=Access("command" * 5, "read" * 5)) as server:
        answer = await server.http.get("/gui/")
        assert answer.text == "the page" and answer.headers["content-security-policy"] == POLICY
        assert (await server.http.get("/gui")).headers["location"].endswith("/gui/")
        assert (await server.http.get("/gui/proto/x.proto")).text == "a file"
        assert (await server.http.get("/gui/nothing")).status_code == 404
        assert (await server.http.get("/gui/..%2fsecret")).status_code == 404
        own = await server.http.get("/api/radars", headers={"authorization": "Bearer " + "read" * 5})
        assert own.headers["content-security-policy"] != POLICY  # no other answer has it


def options(**given: Any) -> argparse.Namespace:
    """The options of a service with Signal K alone, but for those given."""
    return argparse.Namespace(
        **{"signalk": True, "gui": None, "announce": False, "signalk_truth": False, "truth": False} | given
    )


def test_the_port_is_opened_on_request_alone(tmp_path: Path) -> None:
    assert signalk.opened(options(signalk=False)) is None
    assert signalk.opened(options(gui=tmp_path)) is not None
    with pytest.raises(UsageError, match="--gui: is about Signal K; give --signalk"):
        signalk.opened(options(signalk=False, gui=tmp_path))
    with pytest.raises(UsageError, match="is not a folder"):
        signalk.opened(options(gui=tmp_path / "nowhere"))


def test_the_truth_is_told_on_request_and_with_the_truth_alone() -> None:
    assert signalk.opened(options(signalk_truth=True, truth=True)) is not None
    with pytest.raises(UsageError, match="--signalk-truth: is about Signal K"):
        signalk.opened(options(signalk=False, signalk_truth=True, truth=True))
    with pytest.raises(UsageError, match="--signalk-truth: tells the truth"):
        signalk.opened(options(signalk_truth=True))


# announcement: found by zeroconf's own browser; without it, a sentence.
HERE = "127.0.0.1"


def found(port: int) -> Any:
    """What a browser on loopback learns of a service there."""
    pytest.importorskip("zeroconf", reason="the extra announce is absent")
    from zeroconf import ServiceStateChange
    from zeroconf.asyncio import AsyncServiceBrowser, AsyncServiceInfo, AsyncZeroconf

    from radar_service.ports.signalk.announcement import KIND, Announcement

    async def whole() -> Any:
        announcement, reader = Announcement(HERE, port), AsyncZeroconf(interfaces=[HERE])
        changes: asyncio.Queue[tuple[ServiceStateChange, str]] = asyncio.Queue()

        def note(name: str, state_change: ServiceStateChange, **_: Any) -> None:
            changes.put_nowait((state_change, name))

        browser = AsyncServiceBrowser(reader.zeroconf, KIND, handlers=[note])
        await announcement.start()
        while f"port {port}" not in (name := (await changes.get())[1]):
            pass
        info = AsyncServiceInfo(KIND, name)
        assert await info.async_request(reader.zeroconf, 10_000)
        await announcement.stop()
        while (await changes.get()) != (ServiceStateChange.Removed, name):
            pass
        await browser.async_cancel()
        await reader.async_close()
        return info

    return asyncio.run(asyncio.wait_for(whole(), 60))


def test_without_the_package_the_command_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delitem(sys.modules, "radar_service.ports.signalk.announcement", raising=False)
    monkeypatch.setitem(sys.modules, "zeroconf", None)
    assert main(["serve", "harbour", "--signalk", "--announce"]) == 2
    assert capsys.readouterr().err.startswith("announcements need the package zeroconf, of the extra announce;")


def test_what_cannot_be_announced_is_said_in_a_sentence() -> None:
    pytest.importorskip("zeroconf")
    from radar_service.ports.signalk.announcement import Announcement

    for host, number, reason in (
        (HERE, 0, "give --port"),
        ("0.0.0.0", 8000, "give one of this machine"),
        ("::1", 8000, "::1 is no address of IPv4"),
    ):
        with pytest.raises(UsageError, match=reason):
            Announcement(host, number)


def test_a_browser_finds_the_service_and_learns_of_its_end() -> None:
    info = found(8123)
    assert info.port == 8123 and info.parsed_addresses() == [HERE] and info.decoded_properties["self"] == "simulated"


# values: own ship and ships with AIS, with what is not known left out, and values that have not changed.
OWN_SHIP = OwnShipReport(datetime(2026, 1, 1, tzinfo=UTC), (54.0, 8.0), 0.5, 0.6, 7.0, 0.0, (7.0, 0.0), (7.0, 0.0))
SHIP = AisShip("ferry", 21_100_0001, "A", "FERRY", "DABC", 60, 0, "", (0.0, 0.0), 40.0, 40.0, 8.0, 8.0, 5.0)
CONTEXT = "vessels.urn:mrn:imo:mmsi:211000001"


def test_own_ship_as_it_is_reported() -> None:
    assert own_ship_values(OWN_SHIP) == {
        (SELF, "navigation.headingTrue"): 0.5,
        (SELF, "navigation.courseOverGroundTrue"): 0.6,
        (SELF, "navigation.speedOverGround"): 7.0,
        (SELF, "navigation.position"): {"latitude": 54.0, "longitude": 8.0},
    }


def test_of_own_ship_what_is_not_known_is_left_out() -> None:
    lost = own_ship_values(replace(OWN_SHIP, position=None, heading=None, course=None))
    assert lost == {(SELF, "navigation.speedOverGround"): 7.0}


def test_a_ship_with_ais_has_a_context_of_its_own() -> None:
    at = Position(30, 54.1, 8.2, 1.0, 5.0, None, 0.0)
    assert vessel_values(AisReport(SHIP, False, at)) == {
        (CONTEXT, "navigation.courseOverGroundTrue"): 1.0,
        (CONTEXT, "navigation.speedOverGround"): 5.0,
        (CONTEXT, "navigation.position"): {"latitude": 54.1, "longitude": 8.2},
    }
    unknown = vessel_values(AisReport(replace(SHIP, mmsi=99), False, replace(at, latitude=None)))
    assert {context for context, _ in unknown} == {"vessels.urn:mrn:imo:mmsi:000000099"}
    assert not any(path.endswith("position") for _, path in unknown)


def test_an_aid_has_a_name_and_a_position_in_a_context_of_aids_and_a_sart_has_no_name() -> None:
    at = Position(30, 54.1, 8.2, 1.0, 0.0, 2.0, 0.0)
    context = "atons.urn:mrn:imo:mmsi:992110001"
    assert vessel_values(AisReport(replace(SHIP, kind="aid", mmsi=992_110_001), False, at)) == {
        (context, ""): {"name": "FERRY", "mmsi": "992110001"},
        (context, "navigation.position"): {"latitude": 54.1, "longitude": 8.2},
    }
    assert vessel_values(AisReport(replace(SHIP, kind="sart"), False, None, (0,))) == {}


def test_static_data_come_with_the_static_report() -> None:
    assert vessel_values(AisReport(SHIP, False, None, (0,))) == {(CONTEXT, ""): {"name": "FERRY", "mmsi": "211000001"}}
    assert vessel_values(AisReport(SHIP, False, None)) == {}


def test_equal_values_are_told_once() -> None:
    changed: list[ValuePath] = []
    times = iter(("first", "second", "third"))
    values = Values(changed.append, lambda: next(times))
    path = (SELF, "navigation.headingTrue")
    for value in (1.0, 1.0, 2.0):
        values.put({path: value})
    assert changed == [path, path] and values[path] == 2.0 and path in values and values.paths == [path]
    assert values.time(path) == "third"


def test_unchanged_values_are_told_again_on_request() -> None:
    changed: list[ValuePath] = []
    values = Values(changed.append, lambda: "now")
    path = (SELF, "navigation.headingTrue")
    values.put({path: 1.0})
    values.put({path: 1.0}, unchanged_too=True)
    assert changed == [path, path]


# values: targets, the truth of bodies in sight, marked as such; by REST, and by the stream each second.
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
