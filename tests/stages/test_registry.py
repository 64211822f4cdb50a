"""The registry of effects: packages that are broken or claim the same key stop only scenes that have it."""

from dataclasses import dataclass
from typing import Any

import pytest
from pydantic import Field

import radar_service as rs
from radar_service.plug_ins import PlugInError
from radar_service.scene_file.describe import json_schema
from radar_service.sources.numbers import source_names, source_numbers
from radar_service.stages.effect import Effect, Source
from radar_service.stages.registry import effects
from radar_service.truth.ground_truth import scene_hash
from tests.scenes import point, scene
from tests.stages.fixtures import Installed


@dataclass(frozen=True)
class Ice:
    """A record."""

    size: float


class Drift(Effect):
    """Floes at the top of a scene."""

    name, scene_keys, sources = "floes", {"floes": (float, Field(0.0, ge=0, le=9))}, (Source("floe"), Source("brash"))

    def scene_record(self, given: Any) -> Ice:
        return Ice(given["floes"])


class Berg(Effect):
    """Another one, of a body."""

    name, body_keys, sources = "berg", {"berg": (float, Field(0.0))}, (Source("growler"),)

    def body_record(self, given: Any, mesh: Any) -> Ice:
        return Ice(given["berg"])


class Fog(Effect):
    """Of the environment."""

    name, environment_keys, sources = "fog", {"fog_m": (float, Field(0.0, ge=0))}, (Source("fog"),)


class AlsoFloes(Drift):
    """Claims the key of another package."""

    name, scene_keys = "rubble", {"floes": (int, Field(0)), "rubble": (int, Field(0))}


class Thief(Drift):
    """Claims keys of this package."""

    name, scene_keys = "thief", {"radar": (int, Field(0)), "interference": (int, Field(0)), "loot": (int, Field(0))}
    environment_keys = {"sea_texture_shape": (int, Field(0)), "swell": (int, Field(0))}


class Careless(Drift):
    """Has a key whose type has no schema."""

    name, scene_keys = "careless", {"careless": (Ellipsis, Field(0))}


class Ranger(Drift):
    """Would stand in place of a field of the truth."""

    name, scene_keys = "range", {"ranger": (int, Field(0))}


def refusal(**keys: Any) -> str:
    with pytest.raises(rs.SceneError) as refused:
        scene(**keys)
    return str(refused.value)


def test_keys_of_other_packages_are_keys_of_scenes(installed: Installed) -> None:
    plain = scene_hash(scene())
    installed.package("ice-effects", Drift, Berg, Fog)
    made = scene([point("p", 0, 500, berg=3.0)], floes=2.0)
    assert made.effects == {"floes": Ice(2.0)} and made.bodies[0].effects == {"berg": Ice(3.0)}
    assert json_schema()["properties"]["floes"]["maximum"] == 9
    assert refusal(floes=10.0) == "floes: 10 is not allowed; a finite number from 0 to 9; lower it"
    assert 'did you mean "floes"' in refusal(floe=1.0)
    foggy = scene(environment={"fog_m": 300.0})
    assert foggy.environment.effect_keys["fog_m"] == 300.0 and "fog" in source_names(foggy).values()
    assert "fog" not in source_names(scene()).values() and scene_hash(scene()) == plain != scene_hash(foggy)
    assert refusal(environment={"fog_m": -1.0}).startswith("environment.fog_m: -1 is not allowed")


def test_numbers_and_hashes_depend_on_the_scene_alone(installed: Installed) -> None:
    """A package that sorts first changes neither the numbers of another one's sources nor the hash of scenes."""
    plain = scene([point("p", 0, 500)])
    installed.package("ice-effects", Drift)
    before, hashed = source_names(scene(floes=1.0)), scene_hash(scene(floes=1.0))
    assert before[128] == "brash" and before[129] == "floe" and source_numbers(scene(floes=1.0)).tolist() == [128, 129, 4]
    installed.package("a-package", Berg)
    assert source_names(scene(floes=1.0)) == before and scene_hash(scene(floes=1.0)) == hashed != scene_hash(
        scene(floes=2.0)
    )
    again = scene([point("p", 0, 500)])
    assert source_names(again) == source_names(plain) and scene_hash(again) == scene_hash(plain)


def test_two_packages_with_one_key_stop_only_scenes_that_have_it(installed: Installed) -> None:
    installed.package("ice-effects", Drift)
    installed.package("more-ice", AlsoFloes)
    told = "alsofloes of more-ice 1 and drift of ice-effects 1 both have the key floes; uninstall one of them"
    assert refusal(floes=1.0) == f"floes: {told}" and refusal(rubble=1) == f"rubble: {told}"
    assert scene().effects == {}


def test_keys_of_this_package_stay_its_own(installed: Installed) -> None:
    installed.package("thieves", Thief)
    assert refusal(loot=1).endswith(
        "radar-service and thief of thieves 1 both have the key interference; uninstall one of them"
    )
    assert refusal(environment={"swell": 1}).startswith("environment.swell: radar-service and thief of thieves 1 both have")
    assert scene(environment={"sea_texture_shape": 2.0}).environment.effect_keys == {"sea_texture_shape": 2.0}
    assert scene(interference=[{"bearing_deg": 1}]).effects.keys() == {"interference"} and scene().radar is not None


BROKEN = ("no_such_module:Effect", "ice_effects:Missing", "builtins:dict", "ice_effects:Careless", "ice_effects:Ranger")


@pytest.mark.parametrize("broken", BROKEN)
def test_a_package_that_cannot_be_loaded_stops_only_scenes_with_its_key(installed: Installed, broken: str) -> None:
    installed.package("ice-effects", Drift, Careless, Ranger, slush=broken)
    told = refusal(slush=1)
    assert told.startswith("slush: slush of radar_service.effects: the package ice-effects 1 is broken (")
    assert told.endswith("; update or uninstall it") and "\n" not in told
    assert scene(floes=1.0).effects and [effect.name for effect in effects()][-1] == "slush"


class Shards(Drift):
    """Has a source for each thing."""

    name, scene_keys = "shards", {"shards": (int, Field(0))}

    def scene_record(self, given: Any) -> Any:
        return given["shards"]

    def sources_of(self, scene: Any) -> list[Source]:
        return [Source(f"shard {k}") for k in range(self.of_scene(scene) or 0)]


def test_more_sources_than_there_are_numbers_below_those_of_bodies_are_refused(installed: Installed) -> None:
    installed.package("shards", Shards)
    names = source_names(scene([point("p", 0, 500)], shards=128))
    assert (
        names[255].startswith("shard")
        and names[256] == "p"
        and sum(name.startswith("shard") for name in names.values()) == 128
    )
    assert refusal(body=[point("p", 0, 500)], shards=129) == (
        "shards: 129 sources of labels, more than the 128 of other packages; have fewer in the scene, or let `sources_of` give "
        "several things one source"
    )


class Unstaged(Drift):
    """Has a stage that cannot be imported."""

    __module__, stage_at = "ice_effects", "no_such_module:Stage"


def test_a_stage_that_cannot_be_imported_names_its_package(installed: Installed) -> None:
    installed.package("ice-effects", Unstaged)
    told = "unstaged of radar_service.effects: the package ice-effects 1 is broken .ModuleNotFoundError: .*; update or uninstall"
    with pytest.raises(PlugInError, match=told):
        rs.Simulator(scene([point("p", 0, 500)], floes=2.0))
