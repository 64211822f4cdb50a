"""Controls of the Signal K Radar API: definitions, values out, and what requests become of ours."""

import math
from typing import Any

import pytest
from fastapi import HTTPException

from radar_service.ports.signalk.controls import CONTROLS, control_of, own_change, ranges
from radar_service.service.controls import ControlError
from radar_service.service.settings import Settings
from radar_service.world.scene import outline_of
from tests.service.fake import scene

SMALL, LARGE = outline_of(scene()), outline_of(scene(range_max_m=7500.5))


def test_ids_numbers_and_names_are_unique() -> None:
    for keys in ([c.identity for c in CONTROLS], [c.number for c in CONTROLS], [c.name for c in CONTROLS]):
        assert len(set(keys)) == len(keys)
    assert control_of("range").name == "Range"  # clients look for this name


def test_definitions_leave_out_what_they_have_not() -> None:
    """A client of the plotter OpenCPN takes a default for an absent key, and fails at null."""
    for control in CONTROLS:
        definition = control.definition(LARGE)
        assert None not in definition.values()
        assert ("isReadOnly" in definition) == (control.change is None)
    assert control_of("power").definition(SMALL)["descriptions"]["2"] == "Transmit"


def test_ranges_are_those_of_sets_and_all_that_there_is() -> None:
    assert ranges(LARGE) == [231, 463, 926, 1389, 1852, 2778, 3704, 5556, 7408, 7500]
    assert ranges(SMALL) == [200]
    definition = control_of("range").definition(LARGE)
    assert definition["validValues"] == ranges(LARGE) and (definition["minValue"], definition["maxValue"]) == (231, 7500)


STATE: dict[str, Any] = {
    "transmit": True, "range_m": 1852.5, "gain": 45.0, "gain_auto": True, "sea": 20.0, "sea_auto": False, "rain": 3.0,
    "echo_stretch": 0.6, "interference_rejection": True, "scan_correlation": False, "rpm": 24.0,
    "name": "radar 0", "model": "m", "version": "1",
}  # fmt: skip


def test_values_out() -> None:
    values = {control.identity: control.read(STATE) for control in CONTROLS}
    assert values["power"] == {"value": 2} and values["range"] == {"value": 1852.5}
    assert values["gain"] == {"value": 45.0, "auto": True} and values["sea"] == {"value": 20.0, "auto": False}
    assert values["rain"] == {"value": 3.0} and values["targetExpansion"] == {"value": 1}
    assert values["interferenceRejection"] == {"value": 1} and values["scanAverageMode"] == {"value": 0}
    assert values["rotationSpeed"]["value"] == pytest.approx(2.513, abs=5e-4)  # 24 rpm, to the last digit given
    assert control_of("power").read(STATE | {"transmit": False}) == {"value": 1}
    assert control_of("range").read(STATE | {"range_m": 926.0}) == {"value": 926}


@pytest.mark.parametrize(
    ("control", "given", "changed"),
    [
        ("power", 1, {"transmit": False}),
        ("power", "2", {"transmit": True}),
        ("power", {"value": "Transmit"}, {"transmit": True}),
        ("power", {"value": "STANDBY"}, {"transmit": False}),
        ("range", {"value": 1852}, {"range_m": 1852.0}),
        ("range", {"value": "1.5", "units": "nm"}, {"range_m": 2778.0}),
        ("range", {"value": 3, "units": "km"}, {"range_m": 3000.0}),
        ("gain", {"value": 60}, {"gain": 60.0, "gain_auto": False}),
        ("gain", {"value": "60", "auto": True}, {"gain": 60.0, "gain_auto": True}),
        ("gain", {"auto": True}, {"gain_auto": True}),
        ("GAIN", {"value": {"value": 7, "auto": False}}, {"gain": 7.0, "gain_auto": False}),
        ("sea", {"auto": False}, {"sea_auto": False}),
        ("rain", {"value": 5, "auto": True}, {"rain": 5.0}),  # a server in between sends `auto` always
        ("interferenceRejection", "on", {"interference_rejection": True}),
        ("interferenceRejection", False, {"interference_rejection": False}),
        ("interferenceRejection", 1.0, {"interference_rejection": True}),
        ("scanAverageMode", 1, {"scan_correlation": True}),
        ("targetExpansion", 0.6, {"echo_stretch": 0.6}),
        ("rain", {"auto": True}, {}),
    ],
)
def test_changes(control: str, given: Any, changed: dict[str, Any]) -> None:
    result = own_change(control, given, LARGE)
    assert result == pytest.approx(changed, rel=1e-15) and result.keys() == changed.keys()


@pytest.mark.parametrize(
    ("control", "given", "reason"),
    [
        ("power", 0, "power: '0' is not one of 1 .Standby., 2 .Transmit."),
        ("power", 3, "is not one of"),
        ("power", True, "no states"),
        ("gain", "1_0", "is not a number"),
        ("gain", "٥", "is not a number"),
        ("power", {}, "neither"),
        ("power", None, "neither"),
        ("gain", 101, "gain: 101.0"),
        ("gain", {"value": "loud"}, "gain: 'loud' is not a number"),
        ("gain", True, "is not a number"),
        ("gain", [1], "is not a number"),
        ("gain", math.inf, "is not a number"),
        ("gain", "1" * 400, "is not a number"),
        ("gain", {"auto": "perhaps"}, "is not one of 0 .false., 1 .true."),
        ("range", {"value": 1, "units": "furlong"}, "units 'furlong'"),
        ("range", {"value": 1, "units": ["m"]}, "are not m, km, nm"),
        ("range", {"value": 1, "units": {}}, "units '{}'"),
        ("range", 9, "range_m: 9.0"),
        ("targetExpansion", 2.5, "echo_stretch: 2.5"),
        ("rotationSpeed", 3, "read-only"),
        ("userName", "me", "read-only"),
    ],
)
def test_refused_changes_say_what_is_allowed(control: str, given: Any, reason: str) -> None:
    with pytest.raises(ControlError, match=reason):
        own_change(control, given, LARGE)


def test_an_unknown_control_is_answered_with_all() -> None:
    with pytest.raises(HTTPException, match='404: .*no "volume"; there are power, range'):
        own_change("volume", 1, SMALL)


def test_each_value_that_is_shown_may_be_sent_back() -> None:
    """Bulk requests send what was read; only what is read-only is refused."""
    assert Settings().transmit  # the state above is of a radar that transmits
    for control in CONTROLS:
        if control.change is not None:
            own_change(control.identity, dict(control.read(STATE)), LARGE)
