"""Types of the values in a scene file, the base of all its tables, and records of these in SI units and radians."""

import math
from collections.abc import Iterator, Mapping
from inspect import Parameter, signature
from typing import Annotated, Any, Self, TypeVar, cast

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator

from radar_service.numerics import KNOT, MAX_COORDINATE

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
Record = TypeVar("Record")

DEGREE = math.pi / 180.0
SCALES = {  # of the units at the end of keys
    "_deg": DEGREE, "_deg_s": DEGREE, "_kn": KNOT, "_percent": 0.01,
    "_m": 1.0, "_m2": 1.0, "_s": 1.0, "_per_s": 1.0, "_hz": 1.0, "_w": 1.0,
}  # fmt: skip
LEVELS = {"_db": 0.0, "_dbi": 0.0, "_dbsm": 0.0, "_dbm": -3.0}  # of those in decibels: the power of ten that 0 is


class Section(BaseModel):
    """A table of the scene file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    def problems(self) -> Iterator[str]:
        """Yields what is wrong with several keys together, in words that begin with one of them; the first is told."""
        yield from ()

    @model_validator(mode="after")
    def _check(self) -> Self:
        for problem in self.problems():
            raise ValueError(problem)
        return self


def with_keys(model: type[Model], keys: Keys) -> type[Model]:
    """Returns a model with more keys, and the same name."""
    fields: dict[str, Any] = dict(keys)
    return cast(type[Model], create_model(model.__name__, __base__=model, __doc__=model.__doc__, **fields))


def unit_of(key: str) -> str:
    """Returns the unit at the end of a key; "" for none."""
    return max((unit for unit in (*SCALES, *LEVELS) if key.endswith(unit)), key=len, default="")


def bare(key: str) -> str:
    """Returns a key without its unit, as the field of a record is named."""
    return key.removesuffix(unit_of(key))


def scaled(value: Any, scale: float) -> Any:
    """Returns a number, or numbers in tuples, times `scale`; whole numbers and None stay."""
    if isinstance(value, tuple):
        return tuple(scaled(item, scale) for item in value)
    return value * scale if isinstance(value, float) else value


def record_of(kind: type[Record], table: BaseModel, **given: Any) -> Record:
    """Returns a record of a table: each field that is not given is that of the key of its name and a unit. Raises TypeError."""
    keys: dict[str, list[str]] = {}
    for key in type(table).model_fields:
        keys.setdefault(bare(key), []).append(key)
    parameters = signature(kind).parameters
    own = {name: keys[name] for name in parameters if name in keys and name not in given}
    for name, parameter in parameters.items():
        if parameter.default is Parameter.empty and name not in own and name not in given:
            known = f"its keys: {', '.join(type(table).model_fields)}; units: {', '.join((*SCALES, *LEVELS))}"
            what = f"{kind.__name__}.{name}: {type(table).__name__} has no key of this name and a known unit"
            raise TypeError(f"{what} ({known}); rename one, or give {name}= to record_of")
    for name, alike in own.items():
        if len(alike) > 1:
            raise TypeError(
                f"{kind.__name__}.{name}: {type(table).__name__} has {' and '.join(alike)}; give {name}= to record_of"
            )
    return kind(**{name: _in_si(getattr(table, key), unit_of(key)) for name, (key,) in own.items()}, **given)


def _in_si(value: Any, unit: str) -> Any:
    if unit in LEVELS:
        return 10.0 ** (value / 10.0 + LEVELS[unit]) if isinstance(value, float) else value
    return scaled(value, SCALES.get(unit, 1.0))
