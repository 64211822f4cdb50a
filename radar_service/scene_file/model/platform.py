"""The models of a scene file's radars where it has several: each has an id and a platform that carries its antenna."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Annotated, Any, NamedTuple

from pydantic import Discriminator, Field, Tag

from radar_service.radar import FIRST_ID
from radar_service.scene_file.model.radar import RadarModel
from radar_service.stages.fields import Bearing, EastNorth, Latitude, Longitude, Section, with_keys
from radar_service.stages.registry import effects

MAX_RADARS = 16  # each of them computes all that it sees
MAX_NAMED = 6  # names that a message lists


class PlatformModel(Section):
    """What carries an antenna instead of own ship: a body of the scene, or a fixed site."""

    body: str | None = Field(None, min_length=1, max_length=200, description="name of the body that carries the antenna")
    position_m: EastNorth | None = Field(None, description="of a fixed site: east, north")
    latitude_deg: Latitude | None = None
    longitude_deg: Longitude | None = None
    heading_deg: Bearing | None = Field(None, description="of a fixed site: what blind sectors count from; default 0")

    def problems(self) -> Iterator[str]:
        if (self.latitude_deg is None) != (self.longitude_deg is None):
            yield "latitude_deg: this key needs latitude_deg and longitude_deg together; give both or none"
        kinds = [key for key in ("body", "position_m", "latitude_deg") if getattr(self, key) is not None]
        if len(kinds) != 1:
            given = " and ".join(kinds) if kinds else "none of them"
            yield (
                "body: a platform has exactly one of body, position_m, and latitude_deg with longitude_deg; this one has "
                f"{given}: add or remove, or remove platform for own ship"
            )
        if self.body is not None and self.heading_deg is not None:
            yield "heading_deg: the body already defines the heading; remove heading_deg"


class NamedRadarModel(RadarModel):
    """One of several radars: its id, its platform, and all that a single radar has."""

    id: str = Field(
        strict=True, min_length=1, max_length=32, pattern="^[A-Za-z0-9][A-Za-z0-9_-]*$",
        description="letters, digits, - and _; part of addresses, so unique",
    )  # fmt: skip
    platform: PlatformModel | None = Field(None, description="default: own ship")


class RadarEntry(NamedTuple):
    """A radar of a scene file: its id, its key path for messages, its model, and its platform, None for own ship."""

    id: str
    location: str
    model: RadarModel
    platform: PlatformModel | None


def _form(value: Any) -> str:
    """Which form of `radar` a value has; the model of that form then says what is wrong with it."""
    return "list" if isinstance(value, Sequence) and not isinstance(value, str | bytes) else "table"


Radars = RadarModel | tuple[NamedRadarModel, ...]


@cache
def radar_models() -> tuple[type[RadarModel], type[NamedRadarModel]]:
    """The models of a single radar and of one of several, with the keys of all effects."""
    keys = {key: declared for effect in effects() for key, declared in effect.radar_keys.items()}
    return with_keys(RadarModel, keys), with_keys(NamedRadarModel, keys)


def any_radars() -> Any:
    """Returns the type of a scene's radars, with the keys of all effects."""
    single, named = radar_models()
    several = Annotated[tuple[named, ...], Tag("list"), Field(max_length=MAX_RADARS)]  # type: ignore[valid-type]
    return Annotated[Annotated[single, Tag("table")] | several, Discriminator(_form)]


def radar_entries(radars: Radars) -> tuple[RadarEntry, ...]:
    """Returns the radars of a scene file in its order."""
    if isinstance(radars, RadarModel):
        return (RadarEntry(FIRST_ID, "radar", radars, None),)
    return tuple(RadarEntry(radar.id, f"radar[{i}]", radar, radar.platform) for i, radar in enumerate(radars))


def has_sensors(entry: RadarEntry) -> bool:
    """Whether the platform of a radar has gyro, log and position sensor: own ship and bodies have, a fixed site has not."""
    return entry.platform is None or entry.platform.body is not None


def radar_problems(
    radars: Radars, own_ship_body: str | None, can_carry: Mapping[str, bool], has_origin: bool
) -> Iterator[str]:
    """Yields what is wrong: equal ids, and for a platform that the scene does not have.

    own_ship_body: name of the body that is own ship; can_carry: whether each body of the scene, by name, can be a platform.
    """
    if own_ship_body is not None:
        yield from _carrier_problems("own_ship.body", own_ship_body, can_carry)
    if not radar_entries(radars):
        yield f"radar: [] is not allowed; a list of 1 to {MAX_RADARS} radars: add one, or remove the list"
    ids: set[str] = set()
    for entry in radar_entries(radars):
        if entry.id in ids:
            yield f'{entry.location}.id: "{entry.id}" is taken by an earlier radar; ids are unique: change one'
        ids.add(entry.id)
        if entry.platform is not None and entry.platform.body is not None:
            yield from _carrier_problems(f"{entry.location}.platform.body", entry.platform.body, can_carry)
        if entry.platform is not None and entry.platform.latitude_deg is not None and not has_origin:
            yield f"{entry.location}.platform.latitude_deg: latitude and longitude need an [origin] in the scene; add one"


def error_owner_problems(
    radars: Radars, own_ship_body: str | None, own_ship_errs: bool, bodies_with_errors: Mapping[str, int]
) -> Iterator[str]:
    """Yields what is wrong: errors of sensors that no radar uses, and for two tables of one platform.

    own_ship_errs: whether own ship has a table of errors; bodies_with_errors: the number of each body that has one, by name.
    """
    platforms = [entry.platform for entry in radar_entries(radars)]
    has_own_ship = None in platforms
    carriers = {platform.body for platform in platforms if platform is not None} | (
        {own_ship_body} if has_own_ship else set()
    )
    if own_ship_errs and not has_own_ship and own_ship_body not in carriers - {None}:
        yield "own_ship.errors: own ship carries no radar; remove errors, or let a radar stand on own ship"
    for name, k in bodies_with_errors.items():
        if name not in carriers:
            yield (
                f'body[{k}].errors: "{name[:60]}" carries no radar; remove errors, or make the body the platform of a radar'
            )
        if own_ship_errs and name == own_ship_body:
            yield f"own_ship.errors: body[{k}].errors defines the errors of own ship too; remove one of the two"


def _carrier_problems(location: str, name: str, can_carry: Mapping[str, bool]) -> Iterator[str]:
    if name not in can_carry:
        names = [other for other, can in can_carry.items() if can]
        more = f" and {len(names) - MAX_NAMED} more" if len(names) > MAX_NAMED else ""
        known = f"it has {', '.join(names[:MAX_NAMED])}{more}" if names else "it has no body that could carry an antenna"
        yield f'{location}: "{name[:60]}" is not a body of this scene; {known}: correct the name or add the body'
    if not can_carry[name]:
        yield f'{location}: "{name[:60]}" is a height map, which carries no antenna; give a site by position_m'
