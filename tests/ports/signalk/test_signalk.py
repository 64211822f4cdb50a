"""The short modules of the Signal K port, each under its name."""

import argparse
import re
from pathlib import Path
from typing import Any

import pytest
from fastapi import HTTPException
from hypothesis import given, settings
from hypothesis import strategies as st

from radar_service.ports import signalk
from radar_service.ports.signalk.answers import failure, report
from radar_service.ports.signalk.codec import SpokeFields, last_spokes, spoke_bytes, varint
from radar_service.ports.signalk.radars import Radars, legend
from radar_service.ports.signalk.signalk_port import POLICY
from radar_service.processes.limits import MachineBusyError
from radar_service.service.access import Access
from radar_service.service.controls import ControlError
from radar_service.service.radio.station import Station
from radar_service.terminal.arguments import UsageError
from radar_service.world.error import SceneError
from tests.ports.signalk.playing import playing
from tests.ports.signalk.protobuf import spokes
from tests.service.fake import FakeEngine, factory, scene


# answers: reports of the Signal K API from what is raised for a request.
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


def test_varints_of_the_encoding_guide() -> None:
    """Protocol Buffers, Encoding: 1 is 01, 150 is 96 01."""
    assert varint(1) == b"\x01" and varint(150) == b"\x96\x01" and varint(0) == b"\x00" and varint(127) == b"\x7f"


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
