"""Scene file models of bodies, one for each kind. The key that a body has tells its kind: `shape`, `mesh` or `heightmap`."""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Union

from pydantic import BeforeValidator, ConfigDict, Field

from radar_service import plug_ins
from radar_service.scene_file.model.ais import TransponderModel
from radar_service.scene_file.model.errors import PlatformErrorsModel
from radar_service.scene_file.model.moving import MovingSection
from radar_service.stages.fields import (
    Bearing,
    EastNorthUp,
    Flag,
    Height,
    Latitude,
    Longitude,
    Number,
    Offset,
    Section,
    Size,
    Whole,
    with_keys,
)
from radar_service.stages.registry import effects, given_keys
from radar_service.world import HULL_TYPES, PLAIN

MAX_UNITS = 1000  # of a schedule
Instant = Annotated[float, Field(strict=True, ge=0, le=1e9)]  # s of simulated time
SHAPE_SIZES: dict[str, tuple[str, ...]] = {
    "point": (),
    "sphere": ("radius_m",),
    "plate": ("width_m", "height_m"),
    "box": ("length_m", "width_m", "height_m"),
    "cylinder": ("radius_m", "height_m"),
    "dihedral": ("width_m", "height_m"),
    "trihedral": ("edge_m",),
    "hull": ("length_m", "beam_m", "height_m"),
    "reflector": (),
}
REFLECTOR_SIZES = {"corner": "edge_m", "octahedral": "edge_m", "lens": "radius_m"}
SIZES = ("radius_m", "width_m", "height_m", "length_m", "beam_m", "edge_m")


class FadingModel(Section):
    """A schedule that repeats: the body is there in `present` of `of` units, at first."""

    present: Whole = Field(ge=1, le=MAX_UNITS, description="units with the body")
    of: Whole = Field(ge=1, le=MAX_UNITS, description="units after which the schedule repeats")
    unit_s: Annotated[float, Field(strict=True, ge=1e-3, le=1e6)] | None = Field(
        None, description="length of a unit; default: one scan of the radar"
    )
    offset_s: Instant = Field(0.0, description="start of a unit; 0 is the beam at north")
    spread: Flag = Field(False, description="spreads the units with the body evenly, instead of all together")

    def problems(self) -> Iterator[str]:
        if self.present > self.of:
            yield f"present: {self.present} units are more than of = {self.of}; lower present or raise of"

    def pattern(self) -> list[bool]:
        """Returns whether the body is there in each unit of the schedule."""
        if not self.spread:
            return [unit < self.present for unit in range(self.of)]
        return [unit * self.present % self.of < self.present for unit in range(self.of)]


class PlatingModel(Section):
    """Dents of the walls of a metal body between its frames, drawn for each panel."""

    dent_m: Annotated[float, Field(strict=True, ge=0, le=0.02)] = Field(
        0.004, description="mean of the largest depths of panels (IACS: 0.004 standard, 0.008 limit); 0: flat"
    )
    frame_m: Annotated[float, Field(strict=True, ge=0.3, le=3)] = Field(0.7, description="distance of frames")
    panel_height_m: Annotated[float, Field(strict=True, ge=0.5, le=20)] = Field(
        2.5, description="height over which the depth of a panel is drawn"
    )
    seed: Whole = Field(0, ge=0, le=2**32 - 1, description="of the depths")


if TYPE_CHECKING:
    ScatteringName = str
    HullType = str
else:
    ScatteringName = Literal[tuple(plug_ins.names("scattering"))]
    HullType = Literal[HULL_TYPES]


def _with_null_keys(schema: dict[str, Any]) -> None:
    """Lets the JSON Schema of a kind take null for keys of other kinds, where null counts as absent."""
    for key in (*KINDS, *SIZES):
        schema["properties"].setdefault(key, {"type": "null"})


class NamedSection(MovingSection):
    """The keys with which every body begins. The order of keys is that of documents and recordings."""

    name: str = Field(min_length=1, max_length=200)


class ShapeSection(NamedSection):
    """The keys of a built-in shape."""

    shape: Literal["point", "sphere", "plate", "box", "cylinder", "dihedral", "trihedral", "hull", "reflector"]
    radius_m: Size | None = None
    width_m: Size | None = None
    height_m: Size | None = None
    length_m: Size | None = None
    beam_m: Size | None = None
    edge_m: Size | None = None
    reflector: Literal["corner", "octahedral", "lens"] | None = Field(
        None, description='of shape "reflector", by `edge_m`, a lens by `radius_m`, or by its peak at 9.41 GHz, `rcs_dbsm`'
    )
    hung: Literal["catch-rain", "point-up"] = Field(
        "catch-rain", description="of an octahedral reflector: what is on top, an opening or a corner of the plates"
    )
    hull_type: HullType | None = Field(None, description="what stands on a hull, and its flare; default: `plain`")
    hull_seed: Whole | None = Field(
        None, ge=0, le=2**32 - 1, description="of the parts of a hull that is not `plain`; default: 0"
    )


class MeshSection(NamedSection):
    """The keys of a mesh file."""

    mesh: str = Field(min_length=1, max_length=500, description="file inside the scene's own folder")
    scale: Number = Field(1.0, gt=0, le=1e6, description="metres per unit of the mesh file")
    up: Literal["z", "y"] = Field("z", description='the mesh axis that points up; "y" maps (x, y, z) to (x, -z, y)')
    mesh_heading_deg: Bearing = Field(
        0.0, description="where the bow points in the file, after `scale` and `up`: clockwise from its y axis"
    )
    mesh_offset_m: tuple[Offset, Offset, Offset] = Field(
        (0.0, 0.0, 0.0), description="starboard, forward, up: where the origin of the file lies on the turned body"
    )


class HeightMapSection(NamedSection):
    """The keys of a height map."""

    heightmap: str = Field(min_length=1, max_length=500, description="grey PNG, .npy or GeoTIFF")
    low_m: Height | None = Field(None, description="height of the darkest grey")
    high_m: Height | None = Field(None, description="height of the brightest grey")
    extent_m: tuple[Size, Size] | None = Field(None, description="east-west and north-south size, centred on position_m")
    south_west_deg: tuple[Latitude, Longitude] | None = Field(None, description="latitude, longitude of that corner")
    north_east_deg: tuple[Latitude, Longitude] | None = Field(None, description="latitude, longitude of that corner")


class BodyModel(NamedSection):
    """What bodies of every kind have: where and when they are, how they reflect. can_carry: whether they may carry an antenna."""

    model_config = ConfigDict(json_schema_extra=_with_null_keys)
    can_carry: ClassVar[bool] = True

    position_m: EastNorthUp | None = Field(None, description="east, north, height above the sea; default the origin")
    latitude_deg: Latitude | None = None
    longitude_deg: Longitude | None = None
    up_m: Height | None = Field(None, description="height above the sea, with latitude_deg and longitude_deg")
    material: str = Field("steel", description='of a height map "land"')
    scattering: ScatteringName | None = Field(None, description="default by material")
    rcs_dbsm: Number | None = Field(None, ge=-100, le=100)
    swerling: Literal[0, 1, 2, 3, 4] = 0
    mmsi: Whole | None = Field(None, ge=1, le=999_999_999, description="it has an AIS transponder; see `ais`")
    ais: TransponderModel | None = Field(None, description="what its transponder says; needs `mmsi`")
    draught_m: Annotated[float, Field(strict=True, ge=0, le=100)] | None = Field(
        None, description="that AIS reports; default: how deep its mesh reaches"
    )
    plating: PlatingModel | None = Field(
        None, description="how its walls are dented; default: flat, and a table {} for hull types other than `plain`"
    )
    errors: PlatformErrorsModel | None = Field(None, description="of the sensors of a body that carries a radar, on purpose")
    start_s: Instant = Field(0.0, description="when the body appears; it moves from time 0 on all the same")
    end_s: Instant | None = Field(None, description="when it disappears for good; default: never")
    fading: FadingModel | None = Field(None, description="a schedule on which it comes and goes; default: none")

    @property
    def is_geographic(self) -> bool:
        """Whether its position is given in degrees, which needs the origin of the scene."""
        return self.latitude_deg is not None

    def problems(self) -> Iterator[str]:
        yield from super().problems()
        if self.end_s is not None and self.end_s <= self.start_s:
            yield f"end_s: {self.end_s:g} is not after start_s {self.start_s:g}; exchange or remove them"
        if self.ais is not None and self.mmsi is None:
            yield "ais: a transponder has a number; add mmsi"
        for effect in effects():
            if given := given_keys(self, effect.body_keys):
                effect.check_body(given, not self.can_carry)
        yield from self._position_problems()
        if self.scattering == "rcs" and self.rcs_dbsm is None:
            yield 'rcs_dbsm: scattering = "rcs" needs the radar cross-section in dBsm'
        if self.rcs_dbsm is not None and self.scattering not in (None, "rcs"):
            yield f'rcs_dbsm: a declared cross-section excludes scattering = "{self.scattering}"; remove one of the two'
        if self.swerling and self.rcs_dbsm is None:
            yield "swerling: fluctuation is defined for a declared cross-section; add rcs_dbsm"

    def _position_problems(self) -> Iterator[str]:
        geographic = (self.latitude_deg is not None, self.longitude_deg is not None)
        if any(geographic) and not all(geographic):
            yield "latitude_deg: this key needs latitude_deg and longitude_deg together; give both or none"
        if any(geographic) and self.position_m is not None:
            yield "position_m: latitude_deg and longitude_deg already define the position; remove one of the two"
        if any(geographic) and self.track is not None:
            yield "latitude_deg: the track already defines the position; remove latitude_deg and longitude_deg"
        if self.up_m is not None and not any(geographic):
            yield (
                "up_m: this key needs latitude_deg and longitude_deg; with position_m, give the height as its third number"
            )


class ShapeBodyModel(BodyModel, ShapeSection):
    """A body of a built-in shape."""

    def sizes(self) -> dict[str, float]:
        """Returns the sizes of the shape [m], by their keys."""
        return {key: getattr(self, key) for key in SHAPE_SIZES[self.shape]}

    def problems(self) -> Iterator[str]:
        if self.shape == "reflector" or self.reflector is not None or "hung" in self.model_fields_set:
            yield from self._reflector_problems()
        required = SHAPE_SIZES[self.shape] if self.shape != "reflector" else self._reflector_sizes()
        for key in SIZES:
            given = getattr(self, key) is not None
            if key in required and not given:
                yield f'{key}: missing; shape = "{self.shape}" needs {", ".join(required)}: add it'
            if given and key not in required:
                yield f'{key}: shape = "{self.shape}" takes {", ".join(required) or "no sizes"}; remove {key}'
        if self.hull_type is not None and self.shape != "hull":
            yield f'hull_type: shape = "{self.shape}" has none; remove it, or take shape = "hull"'
        if self.hull_seed is not None and self.hull_type in (None, PLAIN):
            yield "hull_seed: a plain hull has no parts to draw; add hull_type or remove hull_seed"
        if self.shape == "point" and self.rcs_dbsm is None:
            yield "rcs_dbsm: a point has no surface; declare its radar cross-section in dBsm"
        yield from super().problems()

    def _reflector_sizes(self) -> tuple[str, ...]:
        """The keys of the size of a reflector; none where its cross-section tells it."""
        assert self.reflector is not None
        return () if self.rcs_dbsm is not None else (REFLECTOR_SIZES[self.reflector],)

    def _reflector_problems(self) -> Iterator[str]:
        if self.shape != "reflector":
            key = "hung" if self.reflector is None else "reflector"
            yield f'{key}: shape = "{self.shape}" is no reflector; give shape = "reflector" or remove {key}'
        if self.reflector is None:
            yield 'reflector: missing; shape = "reflector" needs corner, octahedral or lens: add it'
        if "hung" in self.model_fields_set and self.reflector != "octahedral":
            yield f"hung: a {self.reflector} reflector opens ahead, its axis level; remove hung"
        if self.scattering is not None:
            yield "scattering: a reflector scatters by its own pattern; remove scattering"
        if self.swerling:
            yield "swerling: the pattern of a reflector does not fluctuate; remove swerling"


class MeshBodyModel(BodyModel, MeshSection):
    """A body from a mesh file."""


class HeightMapBodyModel(BodyModel, HeightMapSection):
    """Land from a height map: it has north at its top, and neither moves nor goes."""

    can_carry = False
    material: str = "land"

    @property
    def is_geographic(self) -> bool:
        """Whether its position is given in degrees, which needs the origin of the scene."""
        return self.latitude_deg is not None or self.south_west_deg is not None

    def problems(self) -> Iterator[str]:
        for key in (*MovingSection.model_fields, "start_s", "end_s", "fading", "plating"):
            if getattr(self, key) != type(self).model_fields[key].default:
                yield f"{key}: a height map is land, always there, at rest, north up, without plates; remove {key}"
        if (self.south_west_deg is None) != (self.north_east_deg is None):
            yield "south_west_deg: this key needs north_east_deg; give both or none"
        if self.south_west_deg is not None and self.extent_m is not None:
            yield "extent_m: the corners south_west_deg and north_east_deg define it too; remove one"
        if (self.low_m is None) != (self.high_m is None):
            yield "low_m: low_m and high_m belong together; give both or none"
        if self.low_m is not None and self.high_m is not None and self.high_m <= self.low_m:
            yield f"high_m: {self.high_m:g} is not above low_m {self.low_m:g}; exchange them"
        east_north = (self.position_m or (0.0, 0.0))[:2]
        if self.south_west_deg is not None and (self.latitude_deg is not None or any(east_north)):
            yield (
                "south_west_deg: the corners already define the position; keep only a height in position_m, as [0, 0, up]"
            )
        yield from super().problems()


KINDS: dict[str, type[BodyModel]] = {"shape": ShapeBodyModel, "mesh": MeshBodyModel, "heightmap": HeightMapBodyModel}
OWN_KEYS = {
    kind: tuple(key for key in model.model_fields if key not in BodyModel.model_fields) for kind, model in KINDS.items()
}


class KindlessBodyModel(BodyModel):
    """A body that has none of the keys of kinds, or several: it is refused."""

    shape: Any = None
    mesh: Any = None
    heightmap: Any = None

    def problems(self) -> Iterator[str]:
        given = " and ".join(kind for kind in KINDS if getattr(self, kind) is not None) or "none of them"
        yield f"shape: a body has exactly one of shape, mesh, heightmap; this one has {given}: add or remove"


def _of_its_kind(table: Any) -> Any:
    """Returns the body in a table, as the model of its kind. Raises ValidationError, also for keys of other kinds."""
    if isinstance(table, BodyModel):
        return table
    given = [kind for kind in KINDS if isinstance(table, Mapping) and table.get(kind) is not None]
    model = body_models()[given[0] if len(given) == 1 else ""]
    if isinstance(table, Mapping):
        absent = {key for key in (*KINDS, *SIZES) if table.get(key, "") is None} - model.model_fields.keys()
        absent |= {key for kind in KINDS for key in OWN_KEYS[kind] if len(given) != 1 and key not in KINDS}
        table = {key: value for key, value in table.items() if key not in absent}
    return model.model_validate(table)


BodyOfAKind = ShapeBodyModel | MeshBodyModel | HeightMapBodyModel


@cache
def body_models() -> Mapping[str, type[BodyModel]]:
    """The model of each kind of body with the keys of all effects, and that of a body of no kind, by ""."""
    keys = {key: declared for effect in effects() for key, declared in effect.body_keys.items()}
    kinds: Mapping[str, type[BodyModel]] = {**KINDS, "": KindlessBodyModel}
    return {kind: with_keys(model, keys) for kind, model in kinds.items()}


def any_body() -> Any:
    """Returns the type of a body of any kind, with the keys of all effects."""
    return Annotated[Union[tuple(body_models()[kind] for kind in KINDS)], BeforeValidator(_of_its_kind)]  # noqa: UP007
