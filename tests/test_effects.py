"""The facade for authors of effects, and its page: what that shows runs."""

import re
from pathlib import Path
from typing import Any

import pytest

import radar_service as rs
from radar_service import effects
from tests.stages.fixtures import Installed

PAGE = Path(__file__).parents[1].joinpath("docs/effects.md").read_text(encoding="utf-8")


def test_the_declaration_of_the_page_adds_its_key(installed: Installed) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    names: dict[str, Any] = {"__name__": "page"}
    exec(code, names)
    installed.package("page", names["JammerEffect"])
    scene = rs.load_scene({"jammer": [{"bearing_deg": 20.0}]})
    assert scene.effects["jammer"] == (names["Jammer"](20.0, 40.0),)
    with pytest.raises(rs.SceneError, match=r"jammer\[0\].bearing_deg"):
        rs.load_scene({"jammer": [{}]})


def test_the_page_is_short_and_names_what_the_classes_of_the_facade_have() -> None:
    kinds = (effects.Effect, effects.Stage, effects.EffectTruth, effects.Context, effects.Tile)
    members = {name for kind in kinds for name in dir(kind)}
    assert len(PAGE.splitlines()) <= 65
    for name in (
        "plan",
        "add",
        "echoes",
        "truth",
        "at_crossing",
        "at_end",
        "check_body",
        "check_radar",
        "field_changes",
        "paths",
        "false_echoes",
        "warnings",
        "scene_text",
        "body_text",
    ):
        assert f"`{name}" in PAGE and name in members
