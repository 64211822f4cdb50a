"""The controls of a radar in the terms of the Signal K Radar API. One of them may be two of own: a value and its automatic.

Values are SI. Clients may send numbers as text, names of values in any case, and `auto` where a control has none.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fastapi import HTTPException

from radar_service.numerics import DISPLAY_RANGES
from radar_service.ports.rest.schemas import checked_change
from radar_service.service.controls import ControlError
from radar_service.world import SceneOutline

Values = Mapping[str, Any]
PERCENT = {"minValue": 0, "maxValue": 100, "stepValue": 1}
METRES = {"m": 1.0, "km": 1000.0, "nm": 1852.0}
POWERS = {"0": "Off", "1": "Standby", "2": "Transmit"}
SWITCH = {"0": "Off", "1": "On"}


@dataclass(frozen=True)
class SignalKControl:
    """One control of the API.

    identity: its id there; number: sorts; name, description: for people; category, kind: as the API has them;
    limits: what else its definition has, in a scene; read: its value from the state of our controls;
    change: our controls with the values of a request; None: it is read alone.
    """

    identity: str
    number: int
    name: str
    description: str
    category: str
    kind: str
    limits: Callable[[SceneOutline], Values]
    read: Callable[[Values], Values]
    change: Callable[[Values], dict[str, Any]] | None = None

    def definition(self, scene: SceneOutline) -> dict[str, Any]:
        """Returns its definition in a scene."""
        about = {"id": self.number, "name": self.name, "description": self.description}
        known = about | {"category": self.category, "dataType": self.kind, **self.limits(scene)}
        return known | ({"isReadOnly": True} if self.change is None else {})


def ranges(scene: SceneOutline) -> list[int]:
    """Returns the display ranges [m] that are offered: those of sets, and all that the radar has, rounded down."""
    maximum = int(scene.radar.longest_range)
    return sorted(map(int, scene.radar.scales)) or sorted({*(each for each in DISPLAY_RANGES if each <= maximum), maximum})


def own_change(identity: str, given: Any, scene: SceneOutline) -> dict[str, Any]:
    """Returns our controls that a request for a control of the API changes, by its id in any case.

    given: a value, or an object as the API has it. Raises HTTPException, 404, and ControlError that says what is allowed.
    """
    control = control_of(identity)
    if control.change is None:
        raise ControlError(
            f"{control.identity}: is read-only; PATCH /api/radars/ID/controls changes it where it can be changed"
        )
    values = _as_object(control.identity, given)
    if values.get("value") is None and "hasAuto" not in control.limits(scene):
        return {}  # servers in between send `auto` alone
    return checked_change(control.change(values))


def control_of(identity: str) -> SignalKControl:
    """Returns a control by its id, in any case. Raises HTTPException, 404, that lists those that there are."""
    for control in CONTROLS:
        if control.identity.lower() == identity.lower():
            return control
    raise HTTPException(404, f'control: there is no "{identity[:40]}"; there are {", ".join(c.identity for c in CONTROLS)}')


def _as_object(identity: str, given: Any) -> Values:
    """A request as an object with `value`, `auto` and the like. Servers in between wrap it once more."""
    if isinstance(given, Mapping) and set(given) == {"value"} and isinstance(given["value"], Mapping):
        given = given["value"]
    values: Values = given if isinstance(given, Mapping) else {"value": given}
    if values.get("value") is None and values.get("auto") is None:
        raise ControlError(f'{identity}: the request has neither "value" nor "auto"; send {{"value": ...}}')
    return values


def _number(identity: str, value: Any) -> float:
    try:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise ValueError
        if isinstance(value, str) and not re.fullmatch(r"[-+]?[0-9]{1,9}([.][0-9]{0,9})?", value):
            raise ValueError
        number = float(value)
        if not math.isfinite(number):
            raise ValueError
    except (ValueError, OverflowError):
        raise ControlError(f"{identity}: {str(value)[:40]!r} is not a number; send one") from None
    return number


def _choice(identity: str, value: Any, names: Mapping[str, str]) -> int:
    """The number of a value that is given as number, text or name, among those named."""
    text = str(int(value)) if isinstance(value, bool | float) and float(value).is_integer() else str(value)
    for number, name in names.items():
        if text.lower() in (number, name.lower()):
            return int(number)
    allowed = ", ".join(f"{number} ({name})" for number, name in names.items())
    raise ControlError(f"{identity}: {str(value)[:40]!r} is not one of {allowed}; send one of them")


def _power(values: Values) -> dict[str, Any]:
    if isinstance(values.get("value"), bool):
        raise ControlError("power: true and false are no states; send 1 (Standby) or 2 (Transmit)")
    return {"transmit": _choice("power", values.get("value"), {n: POWERS[n] for n in ("1", "2")}) == 2}


def _range(values: Values) -> dict[str, Any]:
    unit = values.get("units", "m")
    if not isinstance(unit, str) or unit not in METRES:
        raise ControlError(f"range: units {str(unit)[:20]!r} are not {', '.join(METRES)}; send one of them")
    return {"range_m": METRES[unit] * _number("range", values.get("value"))}


def _automatic(name: str, number: int, label: str, description: str) -> SignalKControl:
    """A number from 0 to 100 with an automatic: two of our controls."""

    def change(values: Values) -> dict[str, Any]:
        changed: dict[str, Any] = {}
        if values.get("value") is not None:
            changed = {name: _number(name, values["value"]), f"{name}_auto": False}
        if values.get("auto") is not None:
            changed[f"{name}_auto"] = bool(_choice(name, values["auto"], {"0": "false", "1": "true"}))
        return changed

    return SignalKControl(
        name, number, label, description, "base", "number",
        lambda scene: {**PERCENT, "hasAuto": True, "hasAutoAdjustable": False},
        lambda state: {"value": state[name], "auto": state[f"{name}_auto"]}, change,
    )  # fmt: skip


def _enum(
    identity: str, number: int, label: str, own: str, names: Mapping[str, str], kind: Callable[[int], Any]
) -> SignalKControl:
    """A choice of named values that one of our controls has. kind: our value from the number of the choice."""
    limits = {"minValue": 0, "maxValue": len(names) - 1, "descriptions": dict(names), "validValues": list(range(len(names)))}
    return SignalKControl(
        identity, number, label, f"our control {own}", "advanced", "enum", lambda scene: limits,
        lambda state: {"value": round(float(state[own]))},
        lambda values: {own: kind(_choice(identity, values.get("value"), names))},
    )  # fmt: skip


def _text(identity: str, number: int, label: str, key: str) -> SignalKControl:
    return SignalKControl(
        identity, number, label, "of this simulated radar", "info", "string", lambda scene: {},
        lambda state: {"value": state[key]},
    )  # fmt: skip


CONTROLS = (
    SignalKControl(
        "power", 0, "Power", "standby sends no spokes", "base", "enum",
        lambda scene: {"minValue": 0, "maxValue": 2, "descriptions": POWERS, "validValues": [1, 2]},
        lambda state: {"value": 2 if state["transmit"] else 1}, _power,
    ),
    SignalKControl(
        "range", 2, "Range", "display range", "base", "number",
        lambda scene: {
            "units": "m", "minValue": ranges(scene)[0], "maxValue": ranges(scene)[-1], "validValues": ranges(scene),
        },
        lambda state: {"value": int(range_m) if (range_m := float(state["range_m"])).is_integer() else range_m}, _range,
    ),
    _automatic("gain", 4, "Gain", "1 dB per percent"),
    _automatic("sea", 6, "Sea clutter", "sensitivity time control"),
    SignalKControl(
        "rain", 8, "Rain clutter", "fast time constant", "base", "number", lambda scene: PERCENT,
        lambda state: {"value": state["rain"]}, lambda values: {"rain": _number("rain", values.get("value"))},
    ),
    SignalKControl(
        "targetExpansion", 31, "Target expansion", "lengthens echoes outward", "advanced", "enum",
        lambda scene: {
            "minValue": 0, "maxValue": 2, "descriptions": {"0": "Off", "1": "1 %", "2": "2 %"}, "validValues": [0, 1, 2],
        },
        lambda state: {"value": round(state["echo_stretch"])},
        lambda values: {"echo_stretch": _number("targetExpansion", values.get("value"))},
    ),
    _enum("interferenceRejection", 32, "Interference rejection", "interference_rejection", SWITCH, bool),
    _enum("scanAverageMode", 33, "Scan to scan averaging", "scan_correlation", SWITCH, bool),
    _text("modelName", 50, "Model", "model"),
    _text("firmwareVersion", 51, "Version", "version"),
    _text("userName", 52, "Name", "name"),
    SignalKControl(
        "rotationSpeed", 54, "Rotation speed", "of the antenna", "info", "number",
        lambda scene: {"units": "rad/s", "minValue": 0, "maxValue": 20.0 * math.pi},
        lambda state: {"value": 2.0 * math.pi * state["rpm"] / 60.0},
    ),
)  # fmt: skip
