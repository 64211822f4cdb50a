"""Types of the values in a scene file, and the base of all its tables."""

from collections.abc import Mapping
from typing import Annotated, Any, TypeVar, cast

from pydantic import BaseModel, ConfigDict, Field, create_model

from radar_service.numerics.constants import MAX_COORDINATE

MIN_HEIGHT, MAX_HEIGHT = -11_000.0, 20_000.0  # m above mean sea level

Number = Annotated[float, Field(strict=True)]  # strict: neither true nor "12" is a number
Whole = Annotated[int, Field(strict=True)]
Flag = Annotated[bool, Field(strict=True)]
Coordinate = Annotated[float, Field(strict=True, ge=-MAX_COORDINATE, le=MAX_COORDINATE)]  # m from the origin
Height = Annotated[float, Field(strict=True, ge=MIN_HEIGHT, le=MAX_HEIGHT)]  # m above mean sea level
Size = Annotated[float, Field(strict=True, gt=0, le=100_000)]  # m
Offset = Annotated[float, Field(strict=True, ge=-100_000, le=100_000)]  # m
Bearing = Annotated[float, Field(strict=True, ge=-360, le=360)]  # degrees clockwise from north
Speed = Annotated[float, Field(strict=True, ge=0, le=2000)]  # knots
Latitude = Annotated[float, Field(strict=True, ge=-90, le=90)]
Longitude = Annotated[float, Field(strict=True, ge=-180, le=180)]
EastNorth = tuple[Coordinate, Coordinate]
EastNorthUp = tuple[Coordinate, Coordinate, Height]
Keys = Mapping[str, tuple[Any, Any]]  # of a table: the type and the Field of each
Model = TypeVar("Model", bound=BaseModel)


class Section(BaseModel):
    """A table of the scene file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def with_keys(model: type[Model], keys: Keys) -> type[Model]:
    """Returns a model with more keys, and the same name."""
    fields: dict[str, Any] = dict(keys)
    return cast(type[Model], create_model(model.__name__, __base__=model, __doc__=model.__doc__, **fields))
