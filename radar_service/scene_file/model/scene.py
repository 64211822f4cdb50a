"""The model of a scene file: names, units, ranges and defaults. The engine uses the records of `world` in SI instead.

Field names carry the units of the file (degrees, knots, dB). Unknown keys, NaN and infinities are refused. Validators
check rules that involve several fields; `load` checks the files.
"""

from typing import TYPE_CHECKING, Literal, Self

from pydantic import Field, model_validator

from radar_service.scattering.models import SCATTERING_MODELS
from radar_service.scene_file.model.environment import EnvironmentModel
from radar_service.scene_file.model.errors import ErrorsModel, PlatformErrorsModel
from radar_service.scene_file.model.fields import (
    Bearing,
    EastNorth,
    EastNorthUp,
    Flag,
    Height,
    Latitude,
    Longitude,
    Number,
    Section,
    Size,
    Speed,
    Whole,
)  # fmt: skip
from radar_service.scene_file.model.interference import MAX_INTERFERERS, InterferenceModel
from radar_service.scene_file.model.manoeuvre import TurningSection
from radar_service.scene_file.model.platform import Radars, check_error_owners, check_radars
from radar_service.scene_file.model.presence import FadingModel, Instant
from radar_service.scene_file.model.radar import RadarModel
from radar_service.scene_file.model.sway import SwaySection

MAX_BODIES = 10_000

if TYPE_CHECKING:
    ScatteringName = str
else:
    ScatteringName = Literal[tuple(SCATTERING_MODELS)]


class OriginModel(Section):
    """The position of east = north = 0 on the earth (WGS 84)."""

    latitude_deg: Latitude
    longitude_deg: Longitude


class WaypointModel(Section):
    """A position on a route, and the speed on the leg to it."""

    position_m: EastNorth
    speed_kn: Number = Field(gt=0, le=2000)


class SteerableModel(Section):
    """What commands may order while the radar runs: see docs/commands.md."""

    max_speed_kn: Number = Field(30.0, ge=0, le=2000)
    max_turn_rate_deg_s: Number = Field(5.0, gt=0, le=90, description="also the rate of turns to a course")


class RouteSection(Section):
    """A constant course and speed, or waypoints, or a track from a file."""

    heading_deg: Bearing | None = Field(None, description="default: the course")
    course_deg: Bearing | None = Field(None, description="default: the heading")
    speed_kn: Speed = 0.0
    waypoints: tuple[WaypointModel, ...] = Field((), max_length=1000)
    loop: Flag = Field(False, description="returns to the start after the last waypoint, and repeats")
    turn_radius_m: Size | None = Field(None, description="rounds the corners at waypoints; the heading follows the arc")
    track: str | None = Field(
        None,
        min_length=1,
        max_length=500,
        description="CSV with time_s and east_m, north_m (or latitude_deg, longitude_deg), optional up_m, heading_deg",
    )
    steerable: SteerableModel | None = Field(None, description="a table: commands may steer it; {} for the defaults")


class MovingSection(SwaySection, TurningSection, RouteSection):
    """Motion that own ship and bodies share: a route, turns and manoeuvres, and sway."""

    @model_validator(mode="after")
    def _check_motion(self) -> Self:
        kinds = [bool(self.waypoints), self.track is not None, self.speed_kn > 0]
        if sum(kinds) > 1:
            raise ValueError(
                "speed_kn: only one of speed_kn (with course_deg), waypoints (each with its speed_kn) and track is "
                "allowed; remove the rest"
            )
        if self.course_deg is not None and (self.waypoints or self.track is not None):
            route = "waypoints" if self.waypoints else "the track"
            raise ValueError(f"course_deg: {route} already define the course; remove course_deg")
        if self.track is not None and "position_m" in self.model_fields_set:
            raise ValueError("position_m: the track already defines the position; remove position_m")
        if self.loop and not self.waypoints:
            raise ValueError("loop: only a route of waypoints can repeat; add waypoints or remove loop")
        if self.turn_radius_m is not None and not self.waypoints:
            raise ValueError("turn_radius_m: only corners at waypoints are rounded; add waypoints or remove turn_radius_m")
        by = "waypoints" if self.waypoints else "track" if self.track is not None else None
        self.check_turns(self.heading_deg is not None, by, self.turn_radius_m is not None)
        return self


class OwnShipModel(MovingSection):
    """The ship that carries the antenna."""

    body: str | None = Field(
        None, min_length=1, max_length=200, description="name of the body that is own ship: its motion, and what others see"
    )
    position_m: EastNorth = (0.0, 0.0)
    errors: PlatformErrorsModel | None = Field(None, description="of her sensors, on purpose")

    @model_validator(mode="after")
    def _check_body(self) -> Self:
        if self.body is not None and (others := sorted(self.model_fields_set - {"body", "errors"})):
            raise ValueError(f"{others[0]}: the body already defines how own ship moves; remove {', '.join(others)}")
        return self


SHAPE_SIZES: dict[str, tuple[str, ...]] = {
    "point": (),
    "sphere": ("radius_m",),
    "plate": ("width_m", "height_m"),
    "box": ("length_m", "width_m", "height_m"),
    "cylinder": ("radius_m", "height_m"),
    "dihedral": ("width_m", "height_m"),
    "trihedral": ("edge_m",),
    "hull": ("length_m", "beam_m", "height_m"),
}
SIZES = ("radius_m", "width_m", "height_m", "length_m", "beam_m", "edge_m")
MESH_KEYS = ("scale", "up")
HEIGHTMAP_KEYS = ("low_m", "high_m", "extent_m", "south_west_deg", "north_east_deg")


class BodyModel(MovingSection):
    """An object that the radar can detect: a built-in shape, a mesh file or a height map."""

    name: str = Field(min_length=1, max_length=200)
    shape: Literal["point", "sphere", "plate", "box", "cylinder", "dihedral", "trihedral", "hull"] | None = None
    mesh: str | None = Field(None, min_length=1, max_length=500, description="file inside the scene's own folder")
    heightmap: str | None = Field(None, min_length=1, max_length=500, description="grey PNG, .npy or GeoTIFF")
    radius_m: Size | None = None
    width_m: Size | None = None
    height_m: Size | None = None
    length_m: Size | None = None
    beam_m: Size | None = None
    edge_m: Size | None = None
    scale: Number = Field(1.0, gt=0, le=1e6, description="metres per unit of the mesh file")
    up: Literal["z", "y"] = Field("z", description='the mesh axis that points up; "y" maps (x, y, z) to (x, -z, y)')
    low_m: Height | None = Field(None, description="height of the darkest grey")
    high_m: Height | None = Field(None, description="height of the brightest grey")
    extent_m: tuple[Size, Size] | None = Field(None, description="east-west and north-south size, centred on position_m")
    south_west_deg: tuple[Latitude, Longitude] | None = Field(None, description="latitude, longitude of that corner")
    north_east_deg: tuple[Latitude, Longitude] | None = Field(None, description="latitude, longitude of that corner")
    position_m: EastNorthUp | None = Field(None, description="east, north, height above the sea; default the origin")
    latitude_deg: Latitude | None = None
    longitude_deg: Longitude | None = None
    up_m: Height | None = Field(None, description="height above the sea, with latitude_deg and longitude_deg")
    material: str = "steel"
    scattering: ScatteringName | None = Field(None, description="default by material")
    rcs_dbsm: Number | None = Field(None, ge=-100, le=100)
    swerling: Literal[0, 1, 2, 3, 4] = 0
    mmsi: Whole | None = Field(None, ge=1, le=999_999_999)
    errors: PlatformErrorsModel | None = Field(None, description="of the sensors of a body that carries a radar, on purpose")
    start_s: Instant = Field(0.0, description="when the body appears; it moves from time 0 on all the same")
    end_s: Instant | None = Field(None, description="when it disappears for good; default: never")
    fading: FadingModel | None = Field(None, description="a schedule on which it comes and goes; default: none")

    @model_validator(mode="after")
    def _check_presence(self) -> Self:
        if self.end_s is not None and self.end_s <= self.start_s:
            raise ValueError(f"end_s: {self.end_s:g} is not after start_s {self.start_s:g}; exchange or remove them")
        for key in ("start_s", "end_s", "fading"):
            if self.heightmap is not None and key in self.model_fields_set:
                raise ValueError(f"{key}: a height map is land and always there; remove {key}")
        return self

    @model_validator(mode="after")
    def _check_body(self) -> Self:
        kinds = [k for k in ("shape", "mesh", "heightmap") if getattr(self, k) is not None]
        if len(kinds) != 1:
            given = " and ".join(kinds) if kinds else "none of them"
            raise ValueError(f"shape: a body has exactly one of shape, mesh, heightmap; this one has {given}: add or remove")
        self._check_sizes()
        self._check_position()
        if self.heightmap is not None:
            self._check_heightmap()
        if self.shape == "point" and self.rcs_dbsm is None:
            raise ValueError("rcs_dbsm: a point has no surface; declare its radar cross-section in dBsm")
        if self.scattering == "rcs" and self.rcs_dbsm is None:
            raise ValueError('rcs_dbsm: scattering = "rcs" needs the radar cross-section in dBsm')
        if self.rcs_dbsm is not None and self.scattering not in (None, "rcs"):
            raise ValueError(
                f'rcs_dbsm: a declared cross-section excludes scattering = "{self.scattering}"; remove one of the two'
            )
        if self.swerling and self.rcs_dbsm is None:
            raise ValueError("swerling: fluctuation is defined for a declared cross-section; add rcs_dbsm")
        return self

    def _check_sizes(self) -> None:
        required = SHAPE_SIZES[self.shape] if self.shape else ()
        owner = f'shape = "{self.shape}"' if self.shape else "a body from a file"
        for key in SIZES:
            given = getattr(self, key) is not None
            if key in required and not given:
                raise ValueError(f"{key}: missing; {owner} needs {', '.join(required)}: add it")
            if given and key not in required:
                raise ValueError(f"{key}: {owner} takes {', '.join(required) or 'no sizes'}; remove {key}")
        for kind, keys in (("heightmap", HEIGHTMAP_KEYS), ("mesh", MESH_KEYS)):
            for key in keys:
                if getattr(self, kind) is None and key in self.model_fields_set:
                    raise ValueError(f"{key}: this key needs a body with {kind}; remove it")

    def _check_position(self) -> None:
        geographic = (self.latitude_deg is not None, self.longitude_deg is not None)
        if any(geographic) and not all(geographic):
            raise ValueError("latitude_deg: this key needs latitude_deg and longitude_deg together; give both or none")
        if any(geographic) and self.position_m is not None:
            raise ValueError("position_m: latitude_deg and longitude_deg already define the position; remove one of the two")
        if any(geographic) and self.track is not None:
            raise ValueError("latitude_deg: the track already defines the position; remove latitude_deg and longitude_deg")
        if self.up_m is not None and not any(geographic):
            raise ValueError(
                "up_m: this key needs latitude_deg and longitude_deg; with position_m, give the height as its third number"
            )

    def _check_heightmap(self) -> None:
        if (self.south_west_deg is None) != (self.north_east_deg is None):
            raise ValueError("south_west_deg: this key needs north_east_deg; give both or none")
        if self.south_west_deg is not None and self.extent_m is not None:
            raise ValueError("extent_m: the corners south_west_deg and north_east_deg define it too; remove one")
        if (self.low_m is None) != (self.high_m is None):
            raise ValueError("low_m: low_m and high_m belong together; give both or none")
        if self.low_m is not None and self.high_m is not None and self.high_m <= self.low_m:
            raise ValueError(f"high_m: {self.high_m:g} is not above low_m {self.low_m:g}; exchange them")
        if self.speed_kn > 0 or self.waypoints or self.track is not None:
            raise ValueError("heightmap: a height map cannot move; remove speed_kn, waypoints and track")
        if self.steerable is not None:
            raise ValueError("steerable: a height map cannot move; remove steerable")
        if self.heading_deg is not None or self.course_deg is not None:
            raise ValueError(
                "heading_deg: a height map has north at its top and cannot turn; remove heading_deg, course_deg"
            )
        for key in (*TurningSection.model_fields, *SwaySection.model_fields):
            if key in self.model_fields_set:
                raise ValueError(f"{key}: a height map cannot move; remove {key}")
        east_north = (self.position_m or (0.0, 0.0))[:2]
        if self.south_west_deg is not None and (self.latitude_deg is not None or any(east_north)):
            raise ValueError(
                "south_west_deg: the corners already define the position; keep only a height in position_m, as [0, 0, up]"
            )


class SceneModel(Section):
    """The content of a scene file."""

    name: str = Field("scene", min_length=1, max_length=200)
    origin: OriginModel | None = None
    radar: Radars = RadarModel()
    own_ship: OwnShipModel = OwnShipModel()
    environment: EnvironmentModel = EnvironmentModel()
    body: tuple[BodyModel, ...] = Field((), max_length=MAX_BODIES)
    interference: tuple[InterferenceModel, ...] = Field((), max_length=MAX_INTERFERERS)
    errors: ErrorsModel | None = None

    @model_validator(mode="after")
    def _check_scene(self) -> Self:
        names: set[str] = set()
        for i, body in enumerate(self.body):
            if body.name in names:
                raise ValueError(f'body[{i}].name: "{body.name}" is taken by an earlier body; names are unique: rename one')
            names.add(body.name)
            if self.origin is None and (body.latitude_deg is not None or body.south_west_deg is not None):
                raise ValueError(f"body[{i}].latitude_deg: latitude and longitude need an [origin] in the scene; add one")
        can_carry = {body.name: body.heightmap is None for body in self.body}
        check_radars(self.radar, self.own_ship.body, can_carry, self.origin is not None)
        with_errors = {body.name: i for i, body in enumerate(self.body) if body.errors is not None}
        check_error_owners(self.radar, self.own_ship.body, self.own_ship.errors is not None, with_errors)
        return self
