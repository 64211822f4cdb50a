"""What a scene file may say: names, units, ranges and defaults. Only edges use these; the engine sees `world` records in SI.

Field names carry the units a person writes (degrees, knots, dB). Unknown keys, NaN and infinities are refused. Rules that
span several fields stand in the validators; whether meshes exist and are sound is found out by `load`.
"""

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from radar_service.constants import SPEED_OF_LIGHT

MAX_AZIMUTHS = 16_384  # twice the finest marine radar (8192 spokes)
MAX_BINS = 65_536  # 64 NM at 0.9 m
MAX_CELLS = 2**26  # azimuths x bins: one scan of complex64 is then 512 MiB
MAX_PULSE_SAMPLES = 2**18  # pulse x sample rate
MAX_BODIES = 10_000

Number = Annotated[float, Field(strict=True)]  # strict: neither true nor "12" is a number
Whole = Annotated[int, Field(strict=True)]
Flag = Annotated[bool, Field(strict=True)]
Coordinate = Annotated[
    float, Field(strict=True, ge=-2e6, le=2e6)
]  # m from the origin; the flat map is meaningless farther out
Height = Annotated[float, Field(strict=True, ge=-11_000, le=20_000)]  # m above mean sea level
Size = Annotated[float, Field(strict=True, gt=0, le=100_000)]  # m
Bearing = Annotated[float, Field(strict=True, ge=-360, le=360)]  # degrees clockwise from north
Speed = Annotated[float, Field(strict=True, ge=0, le=2000)]  # knots
Latitude = Annotated[float, Field(strict=True, ge=-90, le=90)]
Longitude = Annotated[float, Field(strict=True, ge=-180, le=180)]
EastNorth = tuple[Coordinate, Coordinate]
EastNorthUp = tuple[Coordinate, Coordinate, Height]


class Section(BaseModel):
    """A table of the scene file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class OriginModel(Section):
    """Where east = north = 0 lies on the earth (WGS 84)."""

    latitude_deg: Latitude
    longitude_deg: Longitude


class RadarModel(Section):
    """The radar: waveform, scan, antenna, receiver."""

    frequency_hz: Number = Field(9.41e9, ge=1e9, le=100e9)
    bandwidth_hz: Number = Field(50e6, ge=1e5, le=2e9)
    pulse_s: Number = Field(10e-6, ge=1e-8, le=1e-3)
    sample_rate_hz: Number | None = Field(None, ge=1e5, le=4e9, description="complex; default 1.5 x bandwidth")
    window: Literal["none", "hamming", "hann", "blackman", "taylor"] = "hamming"
    azimuths: Whole = Field(720, ge=4, le=MAX_AZIMUTHS, description="spokes per scan")
    rpm: Number = Field(24.0, ge=0.01, le=600)
    range_max_m: Number = Field(5000.0, ge=10, le=200_000)
    range_min_m: Number = Field(1.0, gt=0, le=1000, description="1/R^2 stops growing inside this range")
    beamwidth_deg: Number = Field(3.9, ge=0.05, le=90, description="horizontal, one-way, half power")
    beamwidth_el_deg: Number = Field(25.0, ge=0.05, le=180, description="vertical, one-way, half power")
    tilt_deg: Number = Field(0.0, ge=-45, le=45)
    pattern: Literal["sinc2", "printed", "gaussian", "taylor"] | tuple[tuple[Number, Number], ...] = Field(
        "sinc2",
        description="or a table of (offset in degrees, one-way gain in dB), symmetric about 0, for the horizontal",
    )
    height_m: Number = Field(15.0, gt=0, le=5000, description="antenna above the sea")
    power_w: Number = Field(25e3, gt=0, le=1e9)
    gain_dbi: Number = Field(30.0, ge=-20, le=80)
    loss_db: Number = Field(0.0, ge=0, le=60)
    noise_figure_db: Number = Field(4.0, ge=0, le=40)
    polarization: Literal["h", "v"] = "h"
    eclipsing: Flag = Field(False, description="a one-antenna radar is blind while it transmits")
    rays: Whole = Field(2000, ge=1, le=1_000_000, description="per azimuth, for the documented sampler only")
    blind_sectors_deg: tuple[tuple[Bearing, Bearing], ...] = Field(
        (), max_length=16, description="no transmission between these angles, clockwise from the bow"
    )

    @property
    def sampling_hz(self) -> float:
        """The complex sampling rate [Hz], given or by default."""
        return self.sample_rate_hz if self.sample_rate_hz is not None else 1.5 * self.bandwidth_hz

    @property
    def bins(self) -> int:
        """Range bins of a spoke."""
        return math.ceil(self.range_max_m / (SPEED_OF_LIGHT / (2.0 * self.sampling_hz)) - 1e-9)

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        if self.sampling_hz < self.bandwidth_hz:
            raise ValueError(
                f"sample_rate_hz: {self.sampling_hz:g} is below the bandwidth; complex sampling needs at least "
                f"{self.bandwidth_hz:g} Hz: raise sample_rate_hz or lower bandwidth_hz"
            )
        if not 1 <= self.bins <= MAX_BINS:
            raise ValueError(
                f"range_max_m: {self.range_max_m:g} m at {self.sampling_hz:g} samples/s makes {self.bins} range bins; "
                f"at most {MAX_BINS} are allowed: lower range_max_m or sample_rate_hz"
            )
        if self.bins * self.azimuths > MAX_CELLS:
            raise ValueError(
                f"azimuths: {self.azimuths} x {self.bins} range bins are {self.azimuths * self.bins} cells; at most "
                f"{MAX_CELLS} are allowed: lower azimuths, range_max_m or sample_rate_hz"
            )
        if self.pulse_s * self.sampling_hz > MAX_PULSE_SAMPLES:
            raise ValueError(
                f"pulse_s: {self.pulse_s:g} s at {self.sampling_hz:g} samples/s are "
                f"{self.pulse_s * self.sampling_hz:.0f} samples; at most {MAX_PULSE_SAMPLES}: shorten the pulse"
            )
        if isinstance(self.pattern, tuple):
            _check_table(self.pattern)
        return self


def _check_table(table: tuple[tuple[float, float], ...]) -> None:
    if not 2 <= len(table) <= 10_000:
        raise ValueError(f"pattern: a table has 2 to 10000 rows of (degrees, dB), this one has {len(table)}: thin it")
    offsets = [row[0] for row in table]
    if offsets[0] != 0 or offsets[-1] > 180 or any(b <= a for a, b in zip(offsets, offsets[1:], strict=False)):
        raise ValueError(
            "pattern: the offsets start at 0 and rise strictly to at most 180 degrees; sort the rows of the table"
        )
    if table[0][1] != 0 or max(row[1] for row in table) > 0:
        raise ValueError("pattern: gains are in dB below boresight: the first is 0, none is positive; subtract the largest")


class WaypointModel(Section):
    """A place to go to, and the speed of the leg that leads there."""

    position_m: EastNorth
    speed_kn: Number = Field(gt=0, le=2000)


class MovingSection(Section):
    """Motion that own ship and bodies share: a constant course and speed, or waypoints, or a track from a file."""

    heading_deg: Bearing | None = Field(None, description="default: the course")
    course_deg: Bearing | None = Field(None, description="default: the heading")
    speed_kn: Speed = 0.0
    waypoints: tuple[WaypointModel, ...] = Field((), max_length=1000)
    loop: Flag = Field(False, description="after the last waypoint back to the start, for ever")
    track: str | None = Field(
        None,
        min_length=1,
        max_length=500,
        description="CSV with time_s and east_m, north_m (or latitude_deg, longitude_deg), optional up_m, heading_deg",
    )

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        ways = [bool(self.waypoints), self.track is not None, self.speed_kn > 0]
        if sum(ways) > 1:
            raise ValueError(
                "speed_kn: one of speed_kn (with course_deg), waypoints (each with its speed_kn) and track; remove the rest"
            )
        if self.course_deg is not None and (self.waypoints or self.track is not None):
            said = "waypoints" if self.waypoints else "the track"
            raise ValueError(f"course_deg: {said} already say where it goes; remove course_deg")
        if self.track is not None and "position_m" in self.model_fields_set:
            raise ValueError("position_m: the track already says where it is; remove position_m")
        if self.loop and not self.waypoints:
            raise ValueError("loop: only a body with waypoints can go round; add waypoints or remove loop")
        return self


class OwnShipModel(MovingSection):
    """The ship that carries the antenna."""

    position_m: EastNorth = (0.0, 0.0)


class EnvironmentModel(Section):
    """Everything here is off unless asked for."""

    earth: Literal["4/3", "flat"] | Annotated[float, Field(strict=True, gt=0, le=1e6)] = Field(
        "4/3", description="effective earth radius over the earth's radius"
    )
    noise: Flag = False
    multipath: Flag = False
    gas_db_per_km: Literal["itu"] | Annotated[float, Field(strict=True, ge=0, le=10)] = Field(0.0, description="one way")
    rain_mm_h: Number = Field(0.0, ge=0, le=300)
    sea_state: Whole = Field(0, ge=0, le=9, description="Douglas scale")
    wind_from_deg: Bearing = 0.0
    ground_plane: Flag = Field(False, description="a flat reflecting plane at height 0, for the documented fidelity only")


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
    """Anything the radar can see: a built-in shape, a mesh file or a height map."""

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
    scattering: Literal["rcs", "diffuse", "optics"] | None = Field(None, description="default by material")
    rcs_dbsm: Number | None = Field(None, ge=-100, le=100)
    swerling: Literal[0, 1, 2, 3, 4] = 0
    mmsi: Whole | None = Field(None, ge=1, le=999_999_999)

    @model_validator(mode="after")
    def _whole(self) -> Self:
        kinds = [k for k in ("shape", "mesh", "heightmap") if getattr(self, k) is not None]
        if len(kinds) != 1:
            said = " and ".join(kinds) if kinds else "none of them"
            raise ValueError(f"shape: a body has exactly one of shape, mesh, heightmap; this one has {said}: add or remove")
        self._check_sizes()
        self._check_place()
        if self.shape == "point" and self.rcs_dbsm is None:
            raise ValueError("rcs_dbsm: a point has no surface of its own; declare its radar cross-section in dBsm")
        if self.scattering == "rcs" and self.rcs_dbsm is None:
            raise ValueError('rcs_dbsm: scattering = "rcs" needs the radar cross-section in dBsm')
        if self.rcs_dbsm is not None and self.scattering not in (None, "rcs"):
            raise ValueError(f'rcs_dbsm: declared, so scattering cannot be "{self.scattering}"; remove one of the two')
        if self.swerling and self.rcs_dbsm is None:
            raise ValueError("swerling: fluctuation is defined for a declared cross-section; add rcs_dbsm")
        return self

    def _check_sizes(self) -> None:
        wanted = SHAPE_SIZES[self.shape] if self.shape else ()
        owner = f'shape = "{self.shape}"' if self.shape else "a body from a file"
        for key in SIZES:
            given = getattr(self, key) is not None
            if key in wanted and not given:
                raise ValueError(f"{key}: missing; {owner} needs {', '.join(wanted)}: add it")
            if given and key not in wanted:
                raise ValueError(f"{key}: {owner} takes {', '.join(wanted) or 'no sizes'}; remove {key}")
        for kind, keys in (("heightmap", HEIGHTMAP_KEYS), ("mesh", MESH_KEYS)):
            for key in keys:
                if getattr(self, kind) is None and key in self.model_fields_set:
                    raise ValueError(f"{key}: belongs to a body with {kind}; remove it")

    def _check_place(self) -> None:
        geographic = (self.latitude_deg is not None, self.longitude_deg is not None)
        if any(geographic) and not all(geographic):
            raise ValueError("latitude_deg: goes together with longitude_deg; give both or none")
        if any(geographic) and self.position_m is not None:
            raise ValueError("position_m: latitude_deg and longitude_deg already place the body; remove one of the two")
        if any(geographic) and self.track is not None:
            raise ValueError("latitude_deg: the track already says where the body is; remove latitude_deg and longitude_deg")
        if self.up_m is not None and not any(geographic):
            raise ValueError(
                "up_m: goes with latitude_deg and longitude_deg; with position_m the height is its third number"
            )
        if self.heightmap is None:
            return
        if (self.south_west_deg is None) != (self.north_east_deg is None):
            raise ValueError("south_west_deg: goes together with north_east_deg; give both or none")
        if self.south_west_deg is not None and self.extent_m is not None:
            raise ValueError("extent_m: the corners south_west_deg and north_east_deg already say it; remove one of the two")
        if (self.low_m is None) != (self.high_m is None):
            raise ValueError("low_m: goes together with high_m; give both or none")
        if self.low_m is not None and self.high_m is not None and self.high_m <= self.low_m:
            raise ValueError(f"high_m: {self.high_m:g} is not above low_m {self.low_m:g}; exchange them")
        if self.speed_kn > 0 or self.waypoints or self.track is not None:
            raise ValueError("heightmap: a height map cannot move; remove speed_kn, waypoints and track")
        if self.heading_deg is not None or self.course_deg is not None:
            raise ValueError(
                "heading_deg: a height map has north at its top and is not turned; remove heading_deg, course_deg"
            )
        east_north = (self.position_m or (0.0, 0.0))[:2]
        if self.south_west_deg is not None and (any(geographic) or any(east_north)):
            raise ValueError(
                "south_west_deg: the corners already place the map; leave only a height in position_m, as [0, 0, up]"
            )


class SceneModel(Section):
    """A whole scene."""

    name: str = Field("scene", min_length=1, max_length=200)
    origin: OriginModel | None = None
    radar: RadarModel = RadarModel()
    own_ship: OwnShipModel = OwnShipModel()
    environment: EnvironmentModel = EnvironmentModel()
    body: tuple[BodyModel, ...] = Field((), max_length=MAX_BODIES)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        seen: set[str] = set()
        for i, body in enumerate(self.body):
            if body.name in seen:
                raise ValueError(f'body[{i}].name: "{body.name}" is taken by an earlier body; names are unique: rename one')
            seen.add(body.name)
            if self.origin is None and (body.latitude_deg is not None or body.south_west_deg is not None):
                raise ValueError(f"body[{i}].latitude_deg: latitude and longitude need an [origin] in the scene; add one")
        return self
