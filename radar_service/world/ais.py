"""What the AIS transponders of a scene say besides motion, and how they err on purpose. SI units and radians."""

from dataclasses import dataclass
from typing import Literal

StationClass = Literal["A", "B-SO", "B-CS"]
StationKind = Literal["ship", "aid", "sart"]


@dataclass(frozen=True)
class AisSettings:
    """What happens to the reports of all bodies. latency: from the sampled second to the sentence, beside the slot [s].

    loss: share of messages that are not received. position_error: standard deviation, east and north each [m].
    """

    latency: float = 0.0
    loss: float = 0.0
    position_error: float = 0.0


@dataclass(frozen=True)
class AisShip:
    """A transponder.

    body: name of the body that has it, None for own ship that is no body.
    mmsi, imo: its numbers; imo 0: none.
    kind: ship, aid to navigation, or search and rescue transponder that is active.
    antenna: of its position sensor on the deck, starboard and forward of the origin of the body's frame [m].
    to_bow, to_stern, to_port, to_starboard: distances from that antenna to its sides [m]; 0: not known.
    draught: [m]. ship_type: two digits, 0: not known; aid_type: of an aid, 0 to 31, 0: not known.
    silent: periods in which it is off, from and to [s]. heading_error: of what it reports [rad].
    """

    body: str | None
    mmsi: int
    station_class: StationClass
    name: str = ""
    call_sign: str = ""
    ship_type: int = 0
    imo: int = 0
    destination: str = ""
    antenna: tuple[float, float] = (0.0, 0.0)
    to_bow: float = 0.0
    to_stern: float = 0.0
    to_port: float = 0.0
    to_starboard: float = 0.0
    draught: float = 0.0
    silent: tuple[tuple[float, float], ...] = ()
    heading_error: float = 0.0
    kind: StationKind = "ship"
    aid_type: int = 0

    def is_silent(self, time: float) -> bool:
        """Whether it is off at a time [s]."""
        return any(start <= time < end for start, end in self.silent)


@dataclass(frozen=True)
class Ais:
    """The transponders of a scene. ships: in the order of its bodies, own ship that is no body first."""

    ships: tuple[AisShip, ...] = ()
    settings: AisSettings = AisSettings()

    @property
    def of_bodies(self) -> "Ais":
        """The same without own ship that is no body."""
        return Ais(tuple(ship for ship in self.ships if ship.body is not None), self.settings)
