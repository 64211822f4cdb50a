"""The records of the ground truth: at an instant, at beam crossings, and at the end of a scan. SI units and radians."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from radar_service.numerics import Flags, Floats
from radar_service.records.reports import FeedErrorCounts, ReportedOwnShip


@dataclass(frozen=True)
class BodyTruth:
    """A body's state. position: east, north, up [m]; range, azimuth and elevation are those of its origin from the antenna."""

    name: str
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    heading: float
    course: float
    speed: float
    range: float
    azimuth: float  # rad from true north
    elevation: float
    visible: bool
    reason: str  # why not: "", "absent", "beyond range", "below horizon", "blind sector", "shadowed"
    latitude_deg: float | None
    longitude_deg: float | None
    mmsi: int | None
    extent: float  # greatest horizontal distance of its surface from its origin; 0 for a point
    water_course: float | None = None  # and speed through the water; None without a tidal stream
    water_speed: float | None = None


@dataclass(frozen=True)
class Truth:
    """Own ship and every body at `time` [s]."""

    time: float
    own_ship: BodyTruth
    bodies: tuple[BodyTruth, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as REST and the feed send it: SI and radians, the names of the fields."""
        return asdict(self)


@dataclass(frozen=True)
class ShipStates:
    """The true motion of one ship at K times: of own ship's platform, or of the origin of a body's frame.

    time: (K,) [s].
    position, velocity: (K, 3) east, north, up [m, m/s].
    heading: (K,) [rad].
    turn_rate: (K,) of the heading to starboard [rad/s].
    present: (K,) whether it is there; own ship always is.
    """

    time: Floats
    position: Floats
    velocity: Floats
    heading: Floats
    turn_rate: Floats
    present: Flags


@dataclass(frozen=True, kw_only=True)
class OwnShipTruth:
    """Own ship at an instant. position, velocity: east, north, up [m, m/s]; angles [rad]; reported: with errors of sensors.

    course, speed: over ground; water_course, water_speed: through the water, None where the scene has no tidal stream.
    """

    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    heading: float
    course: float
    speed: float
    roll: float
    pitch: float
    yaw: float
    reported: ReportedOwnShip | None = None
    water_course: float | None = None
    water_speed: float | None = None


@dataclass(frozen=True, kw_only=True)
class Kinematics:
    """Where a body's reference point is at an instant, and how it moves. SI, angles [rad] clockwise from true north.

    The reference point is the middle of a vessel's waterline, and otherwise the body's position.

    range, bearing, elevation: from the antenna; relative_bearing: from own ship's bow;
    aspect: bearing of the radar from the body's bow; turn_rate: to starboard [rad/s];
    cpa [m], tcpa [s]: closest point of approach to own ship in plan, if both keep velocity; tcpa is negative where it is past,
    and None where the bodies do not approach or part; length, beam: of the body [m]; reason: why it is not visible;
    course, speed: over ground; water_course, water_speed: through the water, None where the scene has no tidal stream.
    """

    time: float
    radar: str
    body: str
    mmsi: int | None
    range: float
    bearing: float
    relative_bearing: float
    elevation: float
    position: tuple[float, float, float]
    latitude_deg: float | None
    longitude_deg: float | None
    velocity: tuple[float, float, float]
    course: float
    speed: float
    heading: float
    turn_rate: float
    aspect: float
    cpa: float
    tcpa: float | None
    length: float
    beam: float
    visible: bool
    reason: str
    water_course: float | None = None
    water_speed: float | None = None


@dataclass(frozen=True)
class Extent:
    """Bounds of cells, from and to: range [m], bearing [rad], clockwise."""

    range: tuple[float, float]
    bearing: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Radiometry:
    """Where the power of a body lies as the beam crosses it, and how much it is. None: absent, or not asked for.

    The gate is the cells with power within 20 dB of the peak that connect with it; docs/truth.md defines all terms.

    centroid_range, centroid_bearing: of the power in the gate [m, rad].
    centroid_along, centroid_across: of the same from the reference point to the bow and to starboard [m].
    rcs_dbsm: effective cross-section, with the reflection of the sea; rcs_drawn_dbsm: drawn for a body that fluctuates.
    snr_db, scr_db: of the peak over the mean noise, and over the mean of sea and rain in its cell.
    extent, extent_13db: of the gate, and of its cells that are 13 dB above the noise.
    foreign_share: of other sources in the power of the gate.
    """

    centroid_range: float | None = None
    centroid_bearing: float | None = None
    centroid_along: float | None = None
    centroid_across: float | None = None
    rcs_dbsm: float | None = None
    rcs_drawn_dbsm: float | None = None
    snr_db: float | None = None
    scr_db: float | None = None
    extent: Extent | None = None
    extent_13db: Extent | None = None
    foreign_share: float | None = None


@dataclass(frozen=True)
class FalseEcho:
    """An echo of a body that stands where the body is not.

    kind: "indirect", by a structure of own ship there and back, or "multiple", thrown back by own ship.
    by: name of the structure, or "own ship".
    range, bearing: of the echo where it is strongest [m, rad].
    level_db: over the direct echo on boresight; None where the cross-section of the body is not declared.
    """

    kind: str
    by: str
    range: float
    bearing: float
    level_db: float | None


@dataclass(frozen=True, kw_only=True)
class Crossing(Radiometry, Kinematics):
    """The boresight, tilted as own ship rolls and pitches, meets a body's reference point.

    spoke: number of the spoke that is nearest in time; boresight: the azimuth at which the radar observes the point then [rad],
    which is `bearing` where own ship neither rolls nor pitches; effects: what effects tell of the body, by their names;
    structure_db: two-way loss on boresight behind own ship's structures [dB], None for a radar without any;
    false_echoes: of the body as it is at this instant, None for a radar that has none.
    """

    scan: int
    spoke: int
    boresight: float
    own_ship: OwnShipTruth
    effects: Mapping[str, Any] = field(default_factory=dict)
    structure_db: float | None = None
    false_echoes: tuple[FalseEcho, ...] | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as files and feeds have it: the names of the fields that apply, and `type`."""
        content = asdict(self)
        for name in ("structure_db", "false_echoes"):
            if content[name] is None:
                del content[name]
        return {"type": "crossing", **_with_effects(content)}


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """All bodies at the end of a scan, at one `time` [s].

    feed_errors: what happened to its spokes; None: no such errors. effects: what effects tell, by their names.
    """

    scan: int
    time: float
    radar: str
    own_ship: OwnShipTruth
    bodies: tuple[Kinematics, ...]
    feed_errors: FeedErrorCounts | None = None
    effects: Mapping[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as files and feeds have it: the names of the fields, and `type`; no `feed_errors` without such errors."""
        content = asdict(self)
        if self.feed_errors is None:
            del content["feed_errors"]
        return {"type": "snapshot", **_with_effects(content)}


def _with_effects(content: dict[str, Any]) -> dict[str, Any]:
    """Plain data with the truth of each effect under its name, in the place of all."""
    place = [*content].index("effects")
    items = [*content.items()]
    return dict([*items[:place], *content["effects"].items(), *items[place + 1 :]])
