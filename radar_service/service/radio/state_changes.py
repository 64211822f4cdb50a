"""What changes in the state of a radar, besides its spokes: its status, controls, scene, and what was commanded."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from radar_service.scene_file.error_tables import error_tables
from radar_service.service.radio.station import Station
from radar_service.service.radio.status import state

Kind = Literal["status", "controls", "scene", "commands", "errors"]
SECRET: frozenset[Kind] = frozenset({"commands", "errors"})  # for those who may know the truth
STEP = 0.05  # of the factor that a radar which is behind reaches: smaller changes are none


@dataclass(frozen=True)
class StateChange:
    """One change of a radar.

    radar: its id; time: of simulation [s].
    kind: "status" (`state`, `fault`, and `factor_reached` while it is behind; the state of the last one is "ended"), "scene"
    (`epoch`, `name`, `fidelity`), "controls" (those that have changed, as REST gives them), "commands" (`own_ship`, or `bodies`
    by name: the last commands, as REST gives them) or "errors" (all tables of the errors on purpose in force).
    """

    radar: str
    kind: Kind
    values: Mapping[str, Any]
    time: float

    def after(self, earlier: "StateChange") -> "StateChange":
        """Returns one change that stands for an earlier one of this radar and kind, and this one."""
        if self.kind == "controls":
            return replace(self, values={**earlier.values, **self.values})
        if self.kind == "commands":
            bodies = {**earlier.values.get("bodies", {}), **self.values.get("bodies", {})}
            return replace(self, values={**earlier.values, **self.values, **({"bodies": bodies} if bodies else {})})
        return self

    def as_dict(self) -> dict[str, Any]:
        """Returns the change as plain data."""
        return {"radar": self.radar, "kind": self.kind, "values": dict(self.values), "time": self.time}


def ended(station: Station) -> StateChange:
    """Returns the last change of a radar that another scene has ended."""
    values = {"state": "ended", "fault": station.end, "factor_reached": None}
    return StateChange(station.identity, "status", values, station.transmitter.state.simulated)


class StateWatch:
    """Finds the changes of one radar, from look to look. Belongs to the event loop."""

    def __init__(self, station: Station) -> None:
        self._station = station
        self._seen: dict[Kind, Mapping[str, Any]] = {}
        self._epoch, self._commands = station.epoch, 0  # and how many of its commands were seen

    def changes(self) -> list[StateChange]:
        """Returns what has changed since the last look; at the first one all."""
        now = self._now()
        news = {kind: values for kind, values in now.items() if values != self._seen.get(kind)}
        if "controls" in news:
            before = self._seen.get("controls", {})
            controls = {name: value for name, value in news["controls"].items() if value != before.get(name, self)}
            news["controls"] = controls
        if commands := self._commanded():
            news["commands"] = commands
        self._seen = now
        station = self._station
        return [
            StateChange(station.identity, kind, values, station.transmitter.state.simulated) for kind, values in news.items()
        ]

    def _now(self) -> dict[Kind, Mapping[str, Any]]:
        station, epoch, errors = self._station, self._station.epoch, self._station.errors.errors
        name = "" if epoch.is_blind else epoch.info.scene.name
        return {
            "status": self._status(),
            "scene": {"epoch": station.hub.epoch, "name": name, "fidelity": epoch.info.fidelity.name},
            "controls": station.controls(),
            "errors": {} if errors is None else error_tables(errors),
        }

    def _status(self) -> dict[str, Any]:
        now, transmitter = state(self._station), self._station.transmitter
        reached = transmitter.pacer.reached() if now == "behind" else None
        factor = None if reached is None else round(round(reached / STEP) * STEP, 2)
        return {"state": now, "fault": transmitter.state.fault, "factor_reached": factor}

    def _commanded(self) -> Mapping[str, Any]:
        """What was commanded since the last look."""
        epoch = self._station.epoch
        is_new = (
            epoch.name != self._epoch.name and epoch.spoke_source is not self._epoch.spoke_source
        )  # not its range, nor a restart
        another_scene = is_new and not epoch.goes_on
        if another_scene or len(epoch.commands) < self._commands:
            self._commands = 0
        count = len(epoch.commands)
        latest = epoch.commands.latest_after(self._commands)
        self._epoch, self._commands = epoch, count
        own = epoch.info.scene.steerable.own_ship
        ships = [command.as_dict() for command in latest if command.body in (None, own)]
        bodies = {command.body: command.as_dict() for command in latest if command.body not in (None, own)}
        return ({"own_ship": ships[-1]} if ships else {}) | ({"bodies": bodies} if bodies else {})
