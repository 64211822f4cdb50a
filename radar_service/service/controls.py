"""The controls of a radar, each declared once.

`CONTROLS` is the only list: the bodies of `PATCH` and `GET /api/radars/{id}/controls`, the `controls` of a hello, the
`control_definitions` of a radar and from those the controls of the page (`clients/web`) are derived from it. A new control
is one entry here, and the code that applies it.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from radar_service.service.scene_request import SceneRequest, SceneSpokeSource
from radar_service.service.settings import Pace, Settings
from radar_service.world import SceneOutline


class ControlError(ValueError):
    """The value of a control is not allowed on this radar. The text names the control, the value and the limits."""


@dataclass(frozen=True)
class Control:
    """One control.

    name: its key in REST and in the feed;
    kind: switch (true or false), number, or pace (state, steps and factor);
    acts_on: display (the u8 video), transmitter (what is sent, and when) or engine (a rebuilt scene);
    label: its name for people; label_off: of a switch that is off, the same where it is empty;
    description: for people;
    read: the value from the settings and the scene (for engine controls the scene that runs next);
    write: the settings with another value (display and transmitter controls);
    rebuild: the scene request of the scene with another value (engine controls, and the range of a set that is sold);
    unit: of a number; example: a number for the REST documentation; minimum, maximum: its limits, None for none;
    scene_maximum: a maximum that depends on the scene;
    step: of a slider, between its limits; None for a number that is typed.
    """

    name: str
    kind: Literal["switch", "number", "pace"]
    acts_on: Literal["display", "transmitter", "engine"]
    label: str
    description: str
    read: Callable[[Settings, SceneOutline], Any]
    write: Callable[[Settings, SceneOutline, Any], Settings] | None = None
    rebuild: Callable[[SceneRequest, Any], SceneRequest] | None = None
    unit: str = ""
    example: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    scene_maximum: Callable[[SceneOutline], float] | None = None
    step: float | None = None
    label_off: str = ""


def _display_switch(name: str, label: str, description: str, **also: bool) -> Control:
    """A switch of the video: a field of `display.video.Controls`. also: fields that it sets besides."""
    return Control(
        name, "switch", "display", label, description,
        read=lambda settings, scene: getattr(settings.video, name),
        write=lambda settings, scene, value: replace(settings, video=replace(settings.video, **{name: value}, **also)),
    )  # fmt: skip


def _display(
    name: str, description: str, example: float, maximum: float = 100, label: str = "", unit: str = "%", **also: bool
) -> Control:
    """A number of the video from 0 up, as a switch of it."""
    switch = _display_switch(name, label or name.capitalize(), description, **also)
    return replace(switch, kind="number", unit=unit, example=example, minimum=0, maximum=maximum, step=1)


def _longest_range(scene: SceneOutline) -> float:
    return scene.radar.longest_range


def _read_range(settings: Settings, scene: SceneOutline) -> float:
    return min(settings.range or scene.radar.range_max, scene.radar.range_max)


def _write_range(settings: Settings, scene: SceneOutline, value: float) -> Settings:
    return replace(settings, range=None if scene.radar.scales or value == scene.radar.range_max else value)


def _write_pace(settings: Settings, scene: SceneOutline, change: Mapping[str, Any]) -> Settings:
    """Changes state and factor; the state "step" acts on the transmitter at once and changes no setting."""
    pace, factor, state = settings.pace, change.get("factor"), change.get("state")
    if factor is not None:
        pace = replace(pace, factor=math.inf if factor == "max" else factor)
    return replace(settings, pace=Pace(state, pace.factor) if state in ("run", "pause") else pace)


CONTROLS = (
    Control(
        "transmit", "switch", "transmitter", "Transmit", "false is standby: no spokes are sent, simulated time goes on",
        read=lambda settings, scene: settings.transmit,
        write=lambda settings, scene, value: replace(settings, transmit=value), label_off="Standby",
    ),
    Control(
        "range_m", "number", "transmitter", "Range",
        "display range, at most the scene's; a change opens a new epoch; "
        "a set that is sold takes its next longer scale",
        read=_read_range, write=_write_range, rebuild=lambda request, value: replace(request, range_m=value),
        unit="m", example=5000, minimum=10, scene_maximum=_longest_range,
    ),
    _display(
        "gain",
        "1 dB per percent; at 50 a noise sample shows with probability 1e-4; switches auto gain off",
        50, gain_auto=False,
    ),
    _display_switch("gain_auto", "Auto gain", "one false alarm in 1e6 samples of noise, and of what auto sea leaves"),
    _display("sea", "sensitivity time control (STC) against sea clutter, 0 is off; switches auto sea off", 0, sea_auto=False),
    _display_switch("sea_auto", "Auto sea", "subtracts the local level of sea clutter"),
    _display("rain", "fast time constant (FTC) against rain clutter, 0 is off", 0),
    _display("echo_stretch", "lengthens echoes outward by 1 % of the range per unit, 0 is off", 0, 2, "Stretch", ""),
    _display_switch(
        "interference_rejection", "Interference rejection", "removes what only one spoke has, such as pulses of other radars"
    ),
    _display_switch("scan_correlation", "Scan correlation", "removes what only one scan has, such as sea spikes, and fast craft"),
    Control(
        "rpm", "number", "engine", "Antenna", "rate of rotation; a change opens a new epoch, north first, when it is prepared",
        read=lambda settings, scene: 60.0 / scene.radar.rotation_period,
        rebuild=lambda request, value: replace(request, rpm=value), unit="rev/min", example=24, minimum=0.01, maximum=600,
    ),
    Control(
        "pace", "pace", "transmitter", "Pace", "run, pause or step, and simulated seconds per second",
        read=lambda settings, scene: settings.pace.as_dict(), write=_write_pace,
    ),
)  # fmt: skip
DEFINED = ("name", "kind", "unit", "minimum", "maximum", "step", "acts_on", "label", "label_off", "description")


def controls_state(settings: Settings, running: SceneOutline, next_scene: SceneOutline) -> dict[str, Any]:
    """Returns the value of every control. Engine controls are those of the scene that runs next."""
    return {
        control.name: control.read(settings, next_scene if control.acts_on == "engine" else running) for control in CONTROLS
    }


def changed_settings(settings: Settings, scene: SceneOutline, requested: Mapping[str, Any]) -> Settings:
    """Returns the settings with the requested values. Raises ControlError for a value that the scene does not allow."""
    for control in CONTROLS:
        if control.name in requested and control.write is not None:
            _check(control, scene, requested[control.name])
            settings = control.write(settings, scene, requested[control.name])
    return settings


def needs_new_spoke_source(scene: SceneOutline, requested: Mapping[str, Any]) -> bool:
    """Whether a control is among the requested ones that has the scene prepared anew."""
    return any(control.name in requested and _rebuilds(control, scene) for control in CONTROLS)


def _rebuilds(control: Control, scene: SceneOutline) -> bool:
    """Whether a control has the scene prepared anew: a range only of a set with scales."""
    return control.rebuild is not None and (control.write is None or bool(scene.radar.scales))


def changed_request(settings: Settings, spoke_source: SceneSpokeSource, requested: Mapping[str, Any]) -> SceneRequest | None:
    """Returns the scene request of the scene with the requested engine controls, None where it has them already."""
    scene_request = result = spoke_source.scene_request
    scene = spoke_source.info.scene
    for control in CONTROLS:
        if control.name in requested and control.rebuild is not None and _rebuilds(control, scene):
            value = requested[control.name] if control.write is None else scene.radar.scale_for(requested[control.name])
            if not math.isclose(value, control.read(settings, scene), rel_tol=1e-9):
                result = control.rebuild(result, value)
    return None if result is scene_request else result


def control_definitions(scene: SceneOutline) -> list[dict[str, Any]]:
    """Returns the declaration of every control as plain data, with the limits of this scene."""
    return [
        {field: getattr(control, field) for field in DEFINED}
        | ({"maximum": control.scene_maximum(scene)} if control.scene_maximum else {})
        for control in CONTROLS
    ]


def _check(control: Control, scene: SceneOutline, value: Any) -> None:
    if control.scene_maximum is not None and value > control.scene_maximum(scene):
        limits = f"{control.minimum:g} to {control.scene_maximum(scene):g} {control.unit}"
        raise ControlError(f"{control.name}: {value:g}; this radar allows {limits}: give less")
