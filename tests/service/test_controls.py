"""Controls declared once: what is derived from them agrees, and a new one needs no other list."""

from typing import Any

import pytest

from radar_service.display.video import Controls
from radar_service.ports.rest.schemas import ControlsChange, ControlsState
from radar_service.service.controls import (
    CONTROLS,
    ControlError,
    changed_request,
    changed_settings,
    control_definitions,
    controls_state,
)  # fmt: skip
from radar_service.service.settings import Settings
from radar_service.world.error import SceneError
from tests.service.fake import BINS, STEP, FakeEngine, scene, scene_in

NAMES = [control.name for control in CONTROLS]
PUBLIC = ["transmit", "range_m", "gain", "gain_auto", "sea", "sea_auto", "rain", "rpm", "pace"]
# keys of the state that clients rely on, in order


def state(settings: Settings) -> dict[str, Any]:
    return controls_state(settings, scene(), scene())


def test_state_change_and_definitions_have_the_same_controls() -> None:
    definitions = control_definitions(scene())
    assert list(state(Settings())) == NAMES and len(set(NAMES)) == len(NAMES)
    assert [definition["name"] for definition in definitions] == NAMES
    assert list(ControlsChange.model_fields) == list(ControlsState.model_fields) == NAMES


def test_no_public_control_is_lost_or_moved() -> None:
    assert [name for name in NAMES if name in PUBLIC] == PUBLIC


def test_every_control_says_where_it_acts_and_has_the_means() -> None:
    for control in CONTROLS:
        assert (control.rebuild is not None) == (control.acts_on == "engine" or control.name == "range_m")  # that of a set
        assert (control.write is not None) == (control.acts_on != "engine")
        assert control.label and control.description and ControlsState.model_fields[control.name].is_required()


def test_a_number_with_a_step_has_limits_and_does_not_restart_the_engine_while_a_slider_moves() -> None:
    stepped = [control for control in CONTROLS if control.step is not None]
    assert {control.name for control in stepped} >= {"gain", "sea", "rain"}
    for control in stepped:
        assert control.minimum is not None and (control.maximum or control.scene_maximum) is not None
        assert control.acts_on != "engine"


def test_every_setting_of_the_display_is_a_control() -> None:
    assert {c.name for c in CONTROLS if c.acts_on == "display"} == set(vars(Controls()))


def test_definitions_hold_the_limits_of_this_radar() -> None:
    limits = {d["name"]: (d["minimum"], d["maximum"], d["unit"], d["kind"]) for d in control_definitions(scene())}
    assert limits["range_m"] == (10, BINS * STEP, "m", "number") and limits["gain"] == (0, 100, "%", "number")
    assert limits["transmit"] == (None, None, "", "switch") and limits["rpm"] == (0.01, 600, "rev/min", "number")


@pytest.mark.parametrize(
    ("requested", "changed"),
    [
        ({"gain": 60.0}, {"gain": 60.0, "gain_auto": False}), ({"rain": 5.0}, {"rain": 5.0}),
        ({"echo_stretch": 2.0, "interference_rejection": True}, {"echo_stretch": 2.0, "interference_rejection": True}),
        ({"scan_correlation": True}, {"scan_correlation": True}),
        ({"sea": 20.0, "rain": 5.0}, {"sea": 20.0, "sea_auto": False, "rain": 5.0}),
        ({"gain": 60.0, "gain_auto": True}, {"gain": 60.0}), ({"sea_auto": False}, {"sea_auto": False}),
        ({"transmit": False}, {"transmit": False}), ({"range_m": 150.0}, {"range_m": 150.0}), ({}, {}), ({"rpm": 48.0}, {}),
        ({"pace": {"factor": "max"}}, {"pace": {"state": "run", "factor": "max"}}),
        ({"pace": {"state": "pause", "factor": 4}}, {"pace": {"state": "pause", "factor": 4}}),
        ({"pace": {"state": "step", "steps": 3}}, {}),
    ],
)  # fmt: skip
def test_a_change_is_seen_in_the_state_and_nowhere_else(requested: dict[str, Any], changed: dict[str, Any]) -> None:
    assert state(changed_settings(Settings(), scene(), requested)) == state(Settings()) | changed


def test_the_whole_range_is_no_setting_so_that_it_follows_the_scene() -> None:
    settings = changed_settings(Settings(range=50.0), scene(), {"range_m": BINS * STEP})
    assert settings.range is None
    assert controls_state(Settings(range=150.0), scene(range_max_m=100.0), scene())["range_m"] == 100.0


def test_a_range_beyond_the_radar_is_refused_with_the_limits() -> None:
    with pytest.raises(ControlError, match=r"^range_m: 201; this radar allows 10 to 200 m"):
        changed_settings(Settings(), scene(), {"range_m": 201.0})


def test_engine_controls_change_the_scene_that_runs_next() -> None:
    running = FakeEngine(scene())
    changed = changed_request(Settings(), running, {"rpm": 48.0, "gain": 3.0})
    assert changed is not None and scene_in(changed).radar.rotation_period == pytest.approx(60 / 48)
    assert controls_state(Settings(), scene(), scene_in(changed))["rpm"] == pytest.approx(48.0)
    for same in ({"rpm": 24.0 * (1 + 1e-12)}, {"gain": 3.0}):
        assert changed_request(Settings(), running, same) is None
    changed = changed_request(Settings(), FakeEngine(scene(prf_hz=12.0)), {"rpm": 600.0})
    assert changed is not None
    with pytest.raises(SceneError):  # by the process that would run it
        scene_in(changed)
