"""Loads a scene: converts the model to SI units and reads its meshes, height maps and tracks.

Every problem raises a SceneError with the key, the value, the allowed range and the remedy; no other error is raised, but
for the MachineBusyError of a sandbox.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from radar_service.scene_file.bodies import BodyLoader
from radar_service.scene_file.checks.mesh_findings import mesh_notes, mesh_warnings
from radar_service.scene_file.checks.validity import check_antenna, check_echo_power, placement_warnings, validity_warnings
from radar_service.scene_file.convert import (
    OWN_SHIP,
    builder_from_model,
    environment_from_model,
    hull_from_model,
    radar_from_model,
    stream_from_model,
)  # fmt: skip
from radar_service.scene_file.document import SceneInput, model_and_folder
from radar_service.scene_file.error_tables import settings_from_models
from radar_service.scene_file.folder import SceneFolder
from radar_service.scene_file.installations import at_location, distance_warnings, located, reach
from radar_service.scene_file.model.body import HeightMapBodyModel
from radar_service.scene_file.model.platform import PlatformModel, RadarEntry, has_sensors, radar_entries
from radar_service.scene_file.model.scene import SceneModel
from radar_service.scene_file.readers.file_format import IN_PROCESS, MeshReader
from radar_service.scene_file.routes import constant_motion, motion_from_model, start_position
from radar_service.scene_file.transponders import ais_from_models, mmsi_warnings
from radar_service.scene_file.validation_messages import error_from_problems
from radar_service.stages.registry import effect_records, effects_named, numbered_sources
from radar_service.world import Ais, Body, ErrorSettings, Installation, Origin, Platform, Scene, SceneError, World

Made = TypeVar("Made")


def load_scene(source: SceneInput, *, folder: Path | None = None, mesh_reader: MeshReader = IN_PROCESS) -> Scene:
    """Returns the scene in a TOML or JSON file, or in a mapping of the same form.

    source: a path, the name of a packaged scene ("harbour" and "scenes/harbour.toml" work in any folder), or a mapping.
    folder: the folder of its meshes, height maps and tracks; by default that of the file. mesh_reader: reads meshes and
    height maps; use readers.sandbox.Sandbox for untrusted files. Raises only SceneError; with a Sandbox also MachineBusyError.
    """
    return scene_from_model(*model_and_folder(source, folder), mesh_reader)


def model_from(scene_input: SceneInput) -> SceneModel:
    """Returns the validated model of a scene file or mapping, without reading its other files. Raises SceneError."""
    return model_and_folder(scene_input, None)[0]


def scene_from_model(model: SceneModel, folder: Path | None, mesh_reader: MeshReader = IN_PROCESS) -> Scene:
    """Returns the scene in SI units with its files from `folder`. Raises SceneError with a line for each problem."""
    loader = _Loader(model, SceneFolder(folder), mesh_reader)
    bodies = loader.all_bodies()
    if loader.problems:
        raise error_from_problems(loader.problems)
    ais = ais_from_models(model, bodies)
    first, *_ = radars = loader.installations(ais)
    world = World(model.name, loader.origin, first.environment, tuple(bodies))
    loader.warnings[:0] = mesh_warnings(loader.bodies.findings, loader.bodies.hints)
    if loader.origin is not None:
        loader.warnings.extend(distance_warnings(loader.entries, [installation.platform for installation in radars]))
    terrain = [k for k, body in enumerate(model.body) if isinstance(body, HeightMapBodyModel)]
    for entry, installation in zip(loader.entries, radars, strict=True):
        with at_location(entry.location):
            check_echo_power(installation.radar, bodies)
            check_antenna(installation.radar, installation.platform.motion)
        remarks = validity_warnings(world, installation.radar, installation.platform)
        loader.warnings.extend(located(remark, entry.location) for remark in remarks)
        where = (world, installation.radar, installation.platform, terrain)
        loader.warnings.extend(placement_warnings(*where, is_afloat=has_sensors(entry)))
    loader.warnings.extend(mmsi_warnings(ais.ships, [body.name for body in bodies]))
    of_effects = effect_records(model, "scene_keys", lambda effect, given: effect.scene_record(given))
    warnings, notes = tuple(dict.fromkeys(loader.warnings)), tuple(mesh_notes(loader.bodies.findings))
    scene = Scene(
        world, first.radar, first.platform, warnings, of_effects, notes, first.errors, first.id, tuple(radars),
        first.ais, first.gnss_offset,
    )  # fmt: skip
    numbered_sources(scene)  # raises where these are too many
    more = [
        text
        for effect in effects_named(of_effects, first.radar.effects, *(body.effects for body in bodies))
        for text in effect.warnings(scene)
    ]
    return replace(scene, warnings=(*warnings, *more)) if more else scene


class _Loader:
    """Builds the radars, platforms and bodies of one scene, and collects problems and warnings."""

    def __init__(self, model: SceneModel, folder: SceneFolder, mesh_reader: MeshReader) -> None:
        self.model = model
        self.problems: dict[str, None] = {}  # in order, each once
        self.warnings: list[str] = []
        self.origin: Origin | None = None
        if model.origin is not None:
            self.origin = (model.origin.latitude_deg, model.origin.longitude_deg)
        self.entries = radar_entries(model.radar)
        self.radars = [radar_from_model(entry.model) for entry in self.entries]
        self.environments = [self._collected(partial(environment_from_model, model.environment, r)) for r in self.radars]
        self.stream = stream_from_model(model.environment)
        self.seaway = self._collected(partial(builder_from_model, model.environment))
        self.bodies = BodyLoader(model.body, folder, mesh_reader, self.origin, self.radars, self.stream, self.seaway)
        own_ship = self._collected(self._own_ship)
        self.platforms = [own_ship if entry.platform is None else self._platform(entry.platform) for entry in self.entries]
        self.coverage = reach(self.radars, self.platforms)

    def installations(self, ais: Ais) -> list[Installation]:
        """Returns the radars of a scene without problems. ais: all its transponders."""
        parts = zip(self.entries, self.radars, self.platforms, self.environments, strict=True)
        return [
            Installation(
                e.id, radar, carrier, around, self._errors(e), has_sensors(e),
                ais if self._is_own_ship(e) else ais.of_bodies,
                self.model.own_ship.gnss_offset_m if self._is_own_ship(e) else (0.0, 0.0),
            )
            for e, radar, carrier, around in parts
            if carrier and around
        ]  # fmt: skip

    def all_bodies(self) -> list[Body]:
        """Returns the bodies, those last that files have besides their first one, without those whose problems it collects."""
        bodies, k = list[Body](), 0
        while k < len(self.bodies.models):
            if (body := self._collected(partial(self.bodies.body, k, self.coverage))) is not None:
                bodies.append(body)
            k += 1
        return bodies

    def _collected(self, make: Callable[[], Made]) -> Made | None:
        """Returns what `make` makes, or None after collecting its problems."""
        try:
            return make()
        except SceneError as error:
            self.problems.update(dict.fromkeys(error.problems))
            return None

    def _own_ship(self) -> Platform:
        own_ship = self.model.own_ship
        if own_ship.body is not None:
            return self._carrier(own_ship.body)
        start = np.array([*own_ship.position_m, 0.0])
        motion = motion_from_model(own_ship, start, "own_ship", self.bodies.read_track, self.stream)
        if self.seaway is not None and self.seaway.moves(own_ship, is_vessel=True):
            form = hull_from_model(own_ship.hull, OWN_SHIP, own_ship.draught_m, "own_ship")
            motion = self.seaway.moved(motion, own_ship, form, "own ship")
        return Platform(motion)

    def _platform(self, platform: PlatformModel) -> Platform | None:
        if platform.body is not None:
            return self._collected(partial(self._carrier, platform.body))
        start = start_position(platform.latitude_deg, platform.longitude_deg, 0.0, platform.position_m, self.origin)
        return Platform(constant_motion(start, platform.heading_deg, None, 0.0))

    def _errors(self, entry: RadarEntry) -> ErrorSettings | None:
        """Returns the errors of a radar: of all, of its platform's sensors and of its own, the nearest last."""
        own_ship = self.model.own_ship
        body = own_ship.body if entry.platform is None else entry.platform.body
        of_platform = [entry.errors for entry in self.model.body if entry.name == body]
        if self._is_own_ship(entry):
            of_platform.append(own_ship.errors)
        models = (self.model.errors, *of_platform, entry.model.errors)
        return settings_from_models(*models, has_sensors=has_sensors(entry))

    def _is_own_ship(self, entry: RadarEntry) -> bool:
        """Whether own ship carries a radar."""
        own_ship = self.model.own_ship
        return entry.platform is None or (own_ship.body is not None and entry.platform.body == own_ship.body)

    def _carrier(self, name: str) -> Platform:
        """Returns the body of that name as a platform."""
        return Platform(self.bodies.motion_of(name), name)
