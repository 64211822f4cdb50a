"""What an effect declares: its keys in a scene and what becomes of them, its sources, its texts, and where its stage is.

Every process loads declarations, also those that only read scenes. So declarations import nothing of the engine, and
`Effect.stage` imports the stage when it is needed.
"""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, cast

from radar_service import plug_ins
from radar_service.stages.fields import Keys

if TYPE_CHECKING:
    from radar_service.radar import AntennaPattern, Radar
    from radar_service.records import FalseEcho
    from radar_service.stages.stage import Stage
    from radar_service.world import Body, Mesh, Scene

Kind = Literal["ship", "buoy", "land", "clutter", "interference", "noise"]


class Source(NamedTuple):
    """What a label may name. kind: what its plots count as. number, has_echoes: given by effects of this package alone; the scene
    numbers the sources of others, and all of these may have echoes."""

    name: str
    kind: Kind = "interference"
    number: int | None = None
    has_echoes: bool = False


class EffectTruth:
    """What an effect tells of a scene. Safe to call from several threads."""

    def at_crossing(self, body: int, time: float, boresight: float) -> Any:
        """Returns a record or a mapping of a body, by index, as the boresight [rad] meets it at `time` [s]; None for nothing."""
        return None

    def false_echoes(self, body: int, distance: float, bearing: float, heading: float) -> "Sequence[FalseEcho] | None":
        """Returns the echoes of a body, by index, that stand where it is not at an instant; None where the scene has none.

        distance: of its reference point [m]; bearing: of that, heading: of own ship [rad]. Land has none.
        """
        return None

    def at_end(self, time: float) -> Mapping[str, Any] | None:
        """Returns what it tells at the end of a scan, as plain data; None for nothing."""
        return None


class Effect:
    """An effect of a scene. What a subclass leaves out, the effect does not have.

    name: of its record in `Scene.effects`, `Radar.effects` or `Body.effects`, its costs, its truth and its random numbers.
    stage_at: where its stage is, "module:class".
    scene_keys, environment_keys, radar_keys, body_keys: its keys of a scene, of its environment, which has their values
        in `Environment.effect_keys`, of a radar and of a body, each with the type and the Field of pydantic.
    sources: what labels may name of it.
    crossing_record: makes its record of a crossing from keywords.
    has_paths: whether it gives `Stage.paths` to the echoes of bodies, land apart: none of them rests then.
    """

    name: str
    stage_at: ClassVar[str]
    scene_keys: Keys = {}
    environment_keys: Keys = {}
    radar_keys: Keys = {}
    body_keys: Keys = {}
    sources: ClassVar[tuple[Source, ...]] = ()
    crossing_record: ClassVar[Callable[..., Any]] = dict
    has_paths: ClassVar[bool] = False

    def stage(self) -> "type[Stage]":
        """The class of its stage, imported here, as that takes long. Raises PlugInError."""
        own_module, (module, _, name) = type(self).__module__, self.stage_at.partition(":")
        with plug_ins.guarded(next((each for each in plug_ins.entries("effects") if each.module == own_module), None)):
            return cast("type[Stage]", getattr(import_module(module), name))

    def check_body(self, given: Mapping[str, Any], is_land: bool) -> None:
        """Raises ValueError ("key: what is wrong; remedy") where a body may not have these values of its keys."""

    def check_radar(self, given: Mapping[str, Any], pattern: "AntennaPattern", beamwidth: float, wavelength: float) -> None:
        """Raises ValueError ("key: what is wrong; remedy") where a radar may not have these values of its keys.

        pattern, beamwidth: of its antenna, horizontal [rad]; wavelength: [m].
        """

    def scene_record(self, given: Mapping[str, Any]) -> Any:
        """What a scene keeps of the values of its scene keys, in SI units; None for nothing. Raises SceneError."""
        return None

    def radar_record(self, given: Mapping[str, Any]) -> Any:
        """What a radar keeps of the values of its radar keys, in SI units; None for nothing. Raises SceneError."""
        return None

    def body_record(self, given: Mapping[str, Any], mesh: "Mesh | None") -> Any:
        """What a body keeps of the values of its body keys, in SI units; None for nothing. Raises SceneError."""
        return None

    def environment_value(self, key: str, value: Any) -> Any:
        """What an environment keeps of the value of a key, in SI units; () for nothing. An `Attenuator` acts on all echoes."""
        return value

    def warnings(self, scene: "Scene") -> Sequence[str]:
        """Sentences about unusual content of a scene that has its record."""
        return ()

    def scene_text(self, scene: "Scene") -> str:
        """What `check` says of a scene that has its record; without it, the name."""
        return ""

    def body_text(self, body: "Body", radar: "Radar") -> str:
        """What `check` says of a body that has its record."""
        return ""

    def of_scene(self, scene: "Scene") -> Any:
        """Returns its record of a scene, None without one."""
        return scene.effects.get(self.name)

    def of_bodies(self, scene: "Scene") -> dict[int, Any]:
        """Returns its records of the bodies of a scene, by their index."""
        return {k: body.effects[self.name] for k, body in enumerate(scene.bodies) if self.name in body.effects}

    def is_in(self, scene: "Scene") -> bool:
        """Whether a scene asks for it."""
        given = not self.environment_keys.keys().isdisjoint(scene.environment.effect_keys)
        tables = (scene.effects, scene.radar.effects, *(body.effects for body in scene.bodies))
        return given or any(self.name in effects for effects in tables)

    def sources_of(self, scene: "Scene") -> Sequence[Source]:
        """Returns the sources that a scene may have."""
        return self.sources if self.is_in(scene) else ()
