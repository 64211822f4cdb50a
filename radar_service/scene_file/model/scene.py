"""The model of a scene file: names, units, ranges and defaults. The engine uses the records of `world` in SI instead.

Field names carry the units of the file (degrees, knots, dB). Unknown keys, NaN and infinities are refused. Validators
check rules that involve several fields; `load` checks the files.
"""

from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any

from pydantic import Field

from radar_service.scene_file.model.ais import AisModel, TransponderModel
from radar_service.scene_file.model.body import BodyOfAKind, any_body
from radar_service.scene_file.model.environment import EnvironmentModel
from radar_service.scene_file.model.errors import ErrorsModel, PlatformErrorsModel
from radar_service.scene_file.model.moving import MovingSection
from radar_service.scene_file.model.platform import Radars, any_radars, error_owner_problems, radar_models, radar_problems
from radar_service.scene_file.model.radar import RadarModel
from radar_service.stages.fields import EastNorth, Latitude, Longitude, Offset, Section, Whole, with_keys
from radar_service.stages.registry import effects

MAX_BODIES = 10_000


class OriginModel(Section):
    """The position of east = north = 0 on the earth (WGS 84)."""

    latitude_deg: Latitude
    longitude_deg: Longitude


class OwnShipModel(MovingSection):
    """The ship that carries the antenna."""

    body: str | None = Field(
        None, min_length=1, max_length=200, description="name of the body that is own ship: its motion, and what others see"
    )
    position_m: EastNorth = (0.0, 0.0)
    errors: PlatformErrorsModel | None = Field(None, description="of its sensors, on purpose")
    mmsi: Whole | None = Field(None, ge=1, le=999_999_999, description="of own ship that is no body")
    ais: TransponderModel | None = Field(None, description="what its transponder says; needs `mmsi`")
    draught_m: Annotated[float, Field(strict=True, ge=0, le=100)] | None = Field(None, description="that AIS reports")
    gnss_offset_m: tuple[Offset, Offset] = Field(
        (0.0, 0.0), description="of the antenna whose position NMEA 0183 tells: starboard and forward of position_m"
    )

    def problems(self) -> Iterator[str]:
        yield from super().problems()
        if self.body is not None and (others := sorted(self.model_fields_set - {"body", "errors", "gnss_offset_m"})):
            yield f"{others[0]}: the body already defines how own ship moves; remove {', '.join(others)}"
        if self.ais is not None and self.mmsi is None:
            yield "ais: a transponder has a number; add mmsi"


class SceneModel(Section):
    """The content of a scene file."""

    name: str = Field("scene", min_length=1, max_length=200)
    origin: OriginModel | None = None
    radar: Radars = Field(default_factory=RadarModel)
    own_ship: OwnShipModel = OwnShipModel()
    environment: EnvironmentModel = EnvironmentModel()
    body: tuple[BodyOfAKind, ...] = Field((), max_length=MAX_BODIES)
    errors: ErrorsModel | None = None
    ais: AisModel | None = Field(None, description="what happens to AIS reports, on purpose")
    bench: dict[str, Any] | None = Field(None, description="for the command `bench-tracker` alone")

    def problems(self) -> Iterator[str]:
        names, numbers = set[str](), {self.own_ship.mmsi}
        for i, body in enumerate(self.body):
            if body.name in names:
                yield f'body[{i}].name: "{body.name}" is taken by an earlier body; names are unique: rename one'
            names.add(body.name)
            if body.mmsi is not None and body.mmsi in numbers:
                yield f"body[{i}].mmsi: {body.mmsi} is taken; numbers are unique: change one"
            numbers.add(body.mmsi)
            if self.origin is None and body.is_geographic:
                yield f"body[{i}].latitude_deg: latitude and longitude need an [origin] in the scene; add one"
        can_carry = {body.name: body.can_carry for body in self.body}
        yield from radar_problems(self.radar, self.own_ship.body, can_carry, self.origin is not None)
        with_errors = {body.name: i for i, body in enumerate(self.body) if body.errors is not None}
        yield from error_owner_problems(self.radar, self.own_ship.body, self.own_ship.errors is not None, with_errors)


@cache
def scene_model() -> type[SceneModel]:
    """Returns the model of a scene file with the keys of all effects. It is made at its first use, when these can be imported."""
    bodies = (tuple[any_body(), ...], SceneModel.model_fields["body"])  # type: ignore[misc]
    keys = {key: declared for effect in effects() for key, declared in effect.scene_keys.items()}
    of_environment = {key: declared for effect in effects() for key, declared in effect.environment_keys.items()}
    environment, radars = with_keys(EnvironmentModel, of_environment), (any_radars(), radar_models()[0]())
    tables = {"radar": radars, "environment": (environment, environment()), "body": bodies}
    return with_keys(SceneModel, {**tables, **keys})


@cache
def scene_schema() -> dict[str, Any]:
    """Returns the JSON Schema of `scene_model`."""
    return scene_model().model_json_schema()
