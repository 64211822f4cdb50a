"""All effects: those of this package, a line each, and those of other packages by the entry points `radar_service.effects`.

Numbers of sources depend on the scene alone, never on what else is installed. A package that is broken, or two that claim one
key, stop only the scenes that have such a key.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields
from functools import cache, lru_cache
from importlib import import_module
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, BeforeValidator, Field

from radar_service import plug_ins
from radar_service.radar import MAX_OFFSET, Aperture, ChangedPattern, Radar, aperture_of
from radar_service.records import Crossing, Snapshot
from radar_service.stages.effect import Effect, Source
from radar_service.stages.fields import Keys, Section, with_keys
from radar_service.world import SceneError

if TYPE_CHECKING:
    from radar_service.world import Scene

EFFECTS = (  # in the order in which they add to a spoke: sums are bytes
    "radar_service.stages.clutter.effect:ClutterEffect",
    "radar_service.stages.interference.effect:InterferenceEffect",
    "radar_service.stages.beacons.effect:BeaconEffect",
    "radar_service.stages.structures.effect:StructureEffect",
    "radar_service.stages.multiple_echoes.effect:MultipleEffect",
)
HERE = "radar-service"
FIRST_FOREIGN, MAX_FOREIGN = 128, 128  # number of the first source whose effect gives none, above land; up to the bodies


class RefusedEffect(Effect):
    """Takes the place of an effect that cannot be used: a scene with one of its keys ends in a sentence, which says why."""

    def __init__(self, name: str, keys: Iterable[Keys], why: str) -> None:
        """keys: of scenes, environments, radars and bodies."""

        def refuse(_: Any) -> None:
            raise ValueError(why)

        refused = Annotated[Any, BeforeValidator(refuse)], Field(None, description=why)
        self.name = name
        self.scene_keys, self.environment_keys, self.radar_keys, self.body_keys = (dict.fromkeys(k, refused) for k in keys)


@cache
def own_effects() -> tuple[Effect, ...]:
    """Returns the effects of this package."""
    return tuple(_loaded(place)() for place in EFFECTS)


@cache
def effects() -> tuple[Effect, ...]:
    """Returns all effects: first those of this package, then the others by name."""
    own = own_effects()
    others = {f"{each.name} of {plug_ins.package_of(each)}": _foreign(each) for each in plug_ins.entries("effects")}
    owners: dict[str, list[str]] = defaultdict(list)
    for key in {*_core_keys(), *(key for effect in own for key in _claims(effect))}:
        owners[key].append(HERE)
    for label, effect in others.items():
        for key in _claims(effect):
            owners[key].append(label)
    return (*own, *sorted((_settled(effect, owners) for effect in others.values()), key=lambda effect: effect.name))


def _loaded(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def _core_keys() -> Iterator[str]:
    """The keys that scenes, environments, radars and bodies have without effects. Their models import this module, so their names
    are loaded late."""
    yield from _loaded("radar_service.scene_file.model.scene:SceneModel").model_fields
    yield from _loaded("radar_service.scene_file.model.environment:EnvironmentModel").model_fields
    yield from _loaded("radar_service.scene_file.model.platform:NamedRadarModel").model_fields
    for kind in _loaded("radar_service.scene_file.model.body:KINDS").values():
        yield from kind.model_fields


def _key_tables(effect: Effect) -> tuple[Keys, ...]:
    return effect.scene_keys, effect.environment_keys, effect.radar_keys, effect.body_keys


def _claims(effect: Effect) -> set[str]:
    return {effect.name, *(key for keys in _key_tables(effect) for key in keys)}


def _foreign(entry: EntryPoint) -> Effect:
    """The effect of another package; what cannot be loaded is refused by the name of its entry point."""
    try:
        effect = entry.load()()
        with_keys(Section, {key: keys[key] for keys in _key_tables(effect) for key in keys}).model_json_schema()
        assert isinstance(effect, Effect) and effect.name, "it is no Effect with a name"
        names = {field.name for kind in (Crossing, Snapshot) for field in fields(kind)}
        assert effect.name not in names, "the truth has its name"
        assert all(source.number is None for source in effect.sources), "the scene gives its sources their numbers"
    except Exception as error:  # of a package that nobody here has written
        return RefusedEffect(entry.name, [{entry.name: (Any, None)}] * 4, str(plug_ins.broken(entry, error)))
    return effect


def _settled(effect: Effect, owners: dict[str, list[str]]) -> Effect:
    """The effect, or what refuses its keys where others claim one of them; keys of this package stay as they are."""
    shared = sorted(key for key in _claims(effect) if len(owners[key]) > 1)
    if not shared:
        return effect
    why = f"{' and '.join(owners[shared[0]])} both have the key {shared[0]}; uninstall one of them"
    free = [{key: keys[key] for key in keys if HERE not in owners[key]} for keys in _key_tables(effect)]
    return RefusedEffect(effect.name, free, why)


def environment_values(table: BaseModel) -> dict[str, Any]:
    """The values of effects' keys in an environment: all of this package, which every hash has, and of others what is given.
    An empty one is none."""
    own = [key for effect in own_effects() for key in effect.environment_keys]
    given = [(each, key) for each in effects() for key in each.environment_keys if key in {*own, *table.model_fields_set}]
    values = {key: each.environment_value(key, getattr(table, key)) for each, key in given}
    return {key: value for key, value in values.items() if value != ()}


def given_keys(table: BaseModel, keys: Keys) -> dict[str, Any]:
    """The values of an effect's keys in a table that has any of them, {} in another one."""
    return {key: getattr(table, key) for key in keys} if keys.keys() & table.model_fields_set else {}


def effect_records(table: BaseModel, keys: str, record: Callable[[Effect, Mapping[str, Any]], Any]) -> dict[str, Any]:
    """What effects make of a table that has keys of theirs, by their names. keys: "scene_keys", "radar_keys" or "body_keys"."""
    records = {each.name: record(each, given) for each in effects() if (given := given_keys(table, getattr(each, keys)))}
    return {name: content for name, content in records.items() if content is not None}


def effects_named(*names: Iterable[str]) -> list[Effect]:
    """The effects with these names."""
    return [effect for effect in effects() if any(effect.name in some for some in names)]


def effects_in(scene: "Scene") -> list[Effect]:
    """The effects that a scene asks for."""
    return [effect for effect in effects() if effect.is_in(scene)]


def numbered_sources(scene: "Scene") -> dict[int, tuple[str, Source]]:
    """The sources of the effects of a scene by number, each with the name of its effect. Raises SceneError for too many."""
    sources = [(effect.name, source) for effect in effects() for source in effect.sources_of(scene)]
    foreign = sorted((each for each in sources if each[1].number is None), key=lambda each: (each[0], each[1].name))
    if len(foreign) > MAX_FOREIGN:
        raise SceneError(
            f"{' and '.join(sorted({name for name, _ in foreign}))}: {len(foreign)} sources of labels, more than the "
            f"{MAX_FOREIGN} of other packages; have fewer in the scene, or let `sources_of` give several things one source"
        )
    own = {source.number: (name, source) for name, source in sources if source.number is not None}
    return own | dict(enumerate(foreign, FIRST_FOREIGN))


def echo_numbers(scene: "Scene") -> list[int]:
    """The numbers of sources that may have echoes; the `body` of an echo of the k-th is k more than the number of bodies."""
    sources = numbered_sources(scene)
    return [number for number, (_, source) in sources.items() if source.has_echoes or number >= FIRST_FOREIGN]


def numbers_of(scene: "Scene", effect: str) -> tuple[dict[str, int], dict[str, int]]:
    """`Context.numbers` and `Context.echo_sources` of an effect, by its name."""
    numbers = {source.name: number for number, (name, source) in numbered_sources(scene).items() if name == effect}
    echoes = {number: k for k, number in enumerate(echo_numbers(scene), len(scene.bodies))}
    return numbers, {name: echoes[number] for name, number in numbers.items() if number in echoes}


def has_paths(radar: Radar) -> bool:
    """Whether an effect of a radar gives further paths to the echoes of bodies, land apart, so that none of them rests."""
    return any(effect.has_paths for effect in effects_named(radar.effects))


def changed_pattern(radar: Radar, extent: float = MAX_OFFSET) -> ChangedPattern | None:
    """The antenna's pattern as effects of a radar change it, as far off boresight as `extent` [rad]; None where none does."""
    if not radar.effects:
        return None
    aperture = aperture_of(radar.pattern, radar.beamwidth, radar.wavelength)
    records = tuple((each, radar.effects[each.name]) for each in effects_named(radar.effects))
    return None if aperture is None else _changed(aperture, radar.wavelength, records, min(extent, MAX_OFFSET))


@lru_cache(maxsize=8)
def _changed(
    aperture: Aperture, wavelength: float, records: tuple[tuple[Effect, Any], ...], extent: float
) -> ChangedPattern | None:
    parts = [effect.stage().field_changes(record, aperture, wavelength, extent) for effect, record in records]
    changes = [change for part in parts for change in part]
    return ChangedPattern(aperture, wavelength, changes) if changes else None
