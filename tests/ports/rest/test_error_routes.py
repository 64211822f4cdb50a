"""Errors on purpose by REST: what is answered, what is refused, and what clients of the feed receive."""

import asyncio
import contextlib
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.ports.feed.feed_socket import ConnectionErrors
from radar_service.scene_file.load import load_scene
from radar_service.service.access import Access
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Server, Socket
from tests.ports.playing import play, station
from tests.service.fake import AZIMUTHS, RADAR, FakeEngine, factory

ERRORS, CONTROLS = "/api/radars/0/errors", "/api/radars/0/controls"
NONE: dict[str, Any] = dict.fromkeys(("gyro", "log", "position", "antenna", "feed"))


async def step(server: Server, spokes: int) -> None:
    await server.http.patch(CONTROLS, json={"pace": {"state": "step", "steps": spokes}})


async def stepped(server: Server, feed: Socket, spokes: int) -> dict[str, list[Any]]:
    """What a client receives with so many spokes more: the values of each."""
    await step(server, spokes)
    messages = await feed.spokes(spokes)
    columns = {key: [value for message in messages for value in message[key]] for key in ("heading", "course", "azimuth")}
    rows = [message["index"] + k for message in messages for k in range(message["count"])]
    return columns | {"index": rows, "first": [messages[0]["first"]]}


def test_errors_are_told_changed_and_switched_off() -> None:
    async def test(server: Server) -> None:
        assert (await server.http.get(ERRORS)).json() == NONE
        gyro = {"bias_deg": 1.5, "calibration_deg": 0.0, "calibration_phase_deg": 0.0, "noise_deg": 0.0, "noise_time_s": 1.0,
                "latency_s": 0.0}  # fmt: skip
        answer = await server.http.patch(ERRORS, json={"gyro": {"bias_deg": 1.5}})
        assert answer.status_code == 200 and answer.json() == NONE | {"gyro": gyro}
        answer = (
            await server.http.patch(ERRORS, json={"feed": {"heading_lost_s": [[1, 2]], "stuck_sector_deg": [10, 20]}})
        ).json()
        assert answer["gyro"] == gyro and answer["feed"]["heading_lost_s"] == [[1, 2]] and answer["feed"]["late_s"] == 0.5
        assert (await server.http.get(ERRORS)).json() == answer
        assert (await server.http.patch(ERRORS, json={"gyro": None, "feed": {}})).json() == NONE
        assert (await server.http.patch(ERRORS, json={"profile": "imo-a823"})).json()["log"]["bias_kn"] == 0.5
        assert (await server.http.patch(ERRORS, json={})).json()["log"]["bias_kn"] == 0.5
        assert (await server.http.delete(ERRORS)).json() == NONE

    play(test, station(allow_truth=True))


@pytest.mark.parametrize(
    ("body", "status", "line"),
    [
        ('{"gyro": {"bias_deg": NaN}}', 422, "gyro.bias_deg: nan; Input should be a finite number"),
        ('{"gyro": {"bias_deg": 181}}', 422, "gyro.bias_deg: 181; Input should be less than or equal to 180"),
        ('{"gyro": {"bias_deg": "1"}}', 422, "gyro.bias_deg: '1'; Input should be a valid number"),
        ('{"gyroscope": {}}', 422, "gyroscope: {}; Extra inputs are not permitted"),
        ('{"feed": {"heading_lost_s": [[2, 1]]}}', 422, "heading_lost_s[0]: 1 s is not after 2 s"),
        ('{"profile": "imo"}', 422, "profile: 'imo'; Input should be 'imo-a823'"),
        ("[]", 422, "body"),
        ("null", 422, "body"),
        ("", 422, "body"),
        ("{", 422, "JSON"),
    ],
)
def test_bad_bodies_are_refused_and_change_nothing(body: str, status: int, line: str) -> None:
    async def test(server: Server) -> None:
        await server.http.patch(ERRORS, json={"log": {"bias_kn": 2}})
        answer = await server.http.patch(ERRORS, content=body, headers={"content-type": "application/json"})
        assert answer.status_code in (status, 400) and line in " ".join(answer.json()["detail"]), answer.text
        assert (await server.http.get(ERRORS)).json()["log"]["bias_kn"] == 2

    play(test, station(allow_truth=True))


def test_only_who_may_command_changes_errors_and_only_of_radars_that_exist() -> None:
    async def test(server: Server) -> None:
        for method in ("patch", "delete"):
            assert (await server.http.request(method, ERRORS, json={})).status_code == 401
        assert (await server.http.get(ERRORS)).status_code == 403
        token = {"authorization": "Bearer sesame"}
        assert (await server.http.patch(ERRORS, json={}, headers=token)).status_code == 200
        assert (await server.http.get(ERRORS, headers=token)).status_code == 200
        for method in ("get", "patch", "delete"):
            answer = await server.http.request(method, ERRORS.replace("0", "9"), json={}, headers=token)
            assert answer.status_code == 404 and 'there is no "9"' in answer.json()["detail"][0]

    play(test, access=Access(command="sesame"))


def test_clients_receive_what_is_reported_from_the_next_spoke_on() -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        right = await stepped(server, feed, 5)
        await server.http.patch(ERRORS, json={"antenna": {"misalignment_deg": 9}, "gyro": {"bias_deg": 18}})
        wrong = await stepped(server, feed, 5)
        turn = wire.TURN
        expected = np.rint((right["heading"][0] / turn + 18 / 360) * turn) % turn
        assert wrong["heading"] == pytest.approx([expected] * 5, abs=1) and wrong["first"] == [
            5
        ]  # one unit: both are rounded
        assert wrong["azimuth"] == np.rint((np.array(wrong["index"]) / AZIMUTHS + 27 / 360) * turn).astype(int).tolist()
        await server.http.patch(ERRORS, json={"gyro": {}, "antenna": {}, "feed": {"heading_lost_s": [[0, 1e9]]}})
        lost = await stepped(server, feed, 5)
        assert lost["heading"] == lost["course"] == [None] * 5
        expected = np.rint((np.array(lost["index"]) / AZIMUTHS - 30 / 360) * turn)  # from the bow; she heads for 030
        assert lost["azimuth"] == (expected % turn).astype(int).tolist()

    play(test)


def test_blind_spokes_are_those_that_the_radar_does_not_transmit_in() -> None:
    """True sectors: 080 to 100 off a bow of 030, whatever is reported."""

    async def blind(server: Server) -> list[bool]:
        feed = await server.feed()
        await step(server, AZIMUTHS)
        return [
            flag for message in await feed.spokes(AZIMUTHS) for flag in message.get("blind") or [False] * message["count"]
        ]

    seen: list[list[bool]] = []

    async def test(server: Server) -> None:
        await server.http.patch(ERRORS, json=changes.pop())
        seen.append(await blind(server))

    changes: list[dict[str, Any]] = [{}, {"gyro": {"bias_deg": 90}}, {"feed": {"heading_lost_s": [[0, 1e9]]}}]
    for _ in range(3):
        play(test)
    assert seen[0] == seen[1] == seen[2] and any(seen[0])


def test_a_dropped_spoke_leaves_no_gap_in_the_numbers() -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        await server.http.patch(ERRORS, json={"feed": {"drop_rate": 0.3}})
        await step(server, 2 * AZIMUTHS)
        while not only.transmitter.pacer.idle:
            await asyncio.sleep(0.001)
        await server.http.delete(ERRORS)
        await step(server, 1)
        numbers, indices = list[int](), list[int]()
        while not indices or indices[-1] != 2 * AZIMUTHS:
            message = await feed.until("spokes")
            numbers += range(message["first"], message["first"] + message["count"])
            start = message["scan"] * AZIMUTHS + message["index"]
            indices += range(start, start + message["count"])
        assert numbers == list(range(len(numbers))) and len(numbers) < 2 * AZIMUTHS
        assert indices == sorted(set(indices))

    play(test, only := station())


def test_a_slow_connection_carries_each_message(monkeypatch: pytest.MonkeyPatch) -> None:
    carried = list[int]()

    async def carry(_: ConnectionErrors, size: int) -> None:
        carried.append(size)

    async def test(server: Server) -> None:
        feed = await server.feed()
        sizes = [len(await feed.raw())]
        await step(server, AZIMUTHS)
        while len(sizes) < 3:
            sizes.append(len(await feed.raw()))
        assert carried[:3] == sizes

    monkeypatch.setattr(ConnectionErrors, "carry", carry)
    play(test)


def test_frames_take_no_short_cut_past_a_faulty_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    carried, written = list[int](), list[int]()

    async def carry(_: ConnectionErrors, size: int) -> None:
        carried.append(size)

    def write(frame: bytes) -> bool:
        written.append(len(frame))
        return True

    async def test(server: Server) -> None:
        await server.http.patch(ERRORS, json={"feed": {"cut_after_s": 1e6}})
        await server.feed()
        await step(server, AZIMUTHS)
        while not only.transmitter.pacer.idle or len(written) < 5:
            await asyncio.sleep(0.001)
        assert len(written) == len(carried)

    monkeypatch.setattr(ConnectionErrors, "carry", carry)
    monkeypatch.setattr("radar_service.ports.feed.feed_socket.frame_writer", lambda scope: write)
    play(test, only := station())


def test_a_cut_connection_ends_without_a_bye_and_can_be_resumed() -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        hello = await feed.receive()
        await server.http.patch(ERRORS, json={"feed": {"cut_after_s": 0.1}})
        received: list[dict[str, Any]] = []
        while not feed.ended:
            await step(server, 1)
            with contextlib.suppress(TimeoutError):
                received.append(await asyncio.wait_for(feed.receive(), 0.5))  # s, for what takes milliseconds or never comes
        while feed.holds_message:  # on a busy machine it takes longer
            received.append(await feed.receive())
        assert all(message["type"] == "spokes" for message in received)
        await server.http.delete(ERRORS)
        following = await server.feed(f"?since={hello['epoch']}:{len(received)}")
        assert (await following.until("spokes"))["first"] == len(received)  # the one that the cut has swallowed

    play(test)


def test_a_radar_ashore_takes_no_errors_of_a_ships_sensors() -> None:
    ashore = load_scene({"radar": [RADAR | {"id": "shore", "platform": {"position_m": [0, 0]}}]})

    async def test(server: Server) -> None:
        answer = await server.http.patch(errors, json={"gyro": {"bias_deg": 20}})
        assert answer.status_code == 422 and "a fixed site has no gyro" in answer.json()["detail"][0]
        answer = await server.http.patch(errors, json={"profile": "imo-a823"})
        assert [name for name, table in answer.json().items() if table] == ["antenna"]

    errors = "/api/radars/shore/errors"
    play(test, Station("shore", FakeEngine(ashore), factory(), settings=Settings(pace=Pace("pause"))))
