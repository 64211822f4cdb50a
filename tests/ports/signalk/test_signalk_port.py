"""The port: pages of others under /gui/ with a content policy of their own, and its options."""

import argparse
from pathlib import Path
from typing import Any

import pytest

from radar_service.ports import signalk
from radar_service.ports.signalk.signalk_port import POLICY
from radar_service.service.access import Access
from radar_service.terminal.arguments import UsageError
from tests.ports.signalk.playing import playing


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
