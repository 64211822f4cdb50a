"""Loads a scene: converts the model to SI units and reads its meshes, height maps and tracks.

Every problem raises a SceneError with the key, the value, the allowed range and the remedy; no other error is raised, but
for the MachineBusyError of a sandbox.
"""

from collections.abc import Callable, Hashable
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.model import ScatteringModel
from radar_service.scattering.models import SCATTERING_MODELS
from radar_service.scene_file.checks.mesh_axes import axis_findings
from radar_service.scene_file.checks.mesh_findings import Findings, mesh_notes, mesh_warnings
from radar_service.scene_file.checks.placement import placement_warnings
from radar_service.scene_file.checks.validity import check_antenna, check_echo_power, validity_warnings
from radar_service.scene_file.convert import (
    environment_from_model,
    interferer_from_model,
    presence_from_model,
    radar_from_model,
)
from radar_service.scene_file.document import Source, model_and_folder
from radar_service.scene_file.error_tables import settings_from_models
from radar_service.scene_file.folder import SceneFolder
from radar_service.scene_file.installations import at_location, distance_warnings, located, reach
from radar_service.scene_file.model.platform import PlatformModel, RadarEntry, has_sensors, radar_entries
from radar_service.scene_file.model.scene import SHAPE_SIZES, BodyModel, SceneModel
from radar_service.scene_file.readers.heightmap import Coverage, Terrain
from radar_service.scene_file.readers.mesh import MAX_FILE_BYTES, LoadedMesh
from radar_service.scene_file.readers.mesh_reader import IN_PROCESS, MeshReader
from radar_service.scene_file.readers.raster import MAX_FILE_BYTES as MAX_RASTER_BYTES
from radar_service.scene_file.readers.track import MAX_TRACK_BYTES, motion_from_track
from radar_service.scene_file.routes import constant_motion, motion_from_model
from radar_service.scene_file.validation_messages import error_from_problems
from radar_service.world.body import Body, Mesh
from radar_service.world.error import SceneError
from radar_service.world.error_settings import ErrorSettings
from radar_service.world.geo import Origin, map_from_geographic
from radar_service.world.materials import VESSEL_MATERIALS, material_from_name
from radar_service.world.motion import Motion
from radar_service.world.platform import Installation, Platform
from radar_service.world.scene import Scene, World
from radar_service.world.shapes import shape_mesh

Floats = NDArray[np.float64]
Made = TypeVar("Made")
Key = TypeVar("Key", bound=Hashable)


def load_scene(source: Source, *, folder: Path | None = None, mesh_reader: MeshReader = IN_PROCESS) -> Scene:
    """Returns the scene in a TOML or JSON file, or in a mapping of the same form.

    source: a path, the name of a packaged scene ("harbour" and "scenes/harbour.toml" work in any folder), or a mapping.
    folder: the folder of its meshes, height maps and tracks; by default that of the file. mesh_reader: reads meshes and
    height maps; use readers.sandbox.Sandbox for untrusted files. Raises only SceneError; with a Sandbox also MachineBusyError.
    """
    return scene_from_model(*model_and_folder(source, folder), mesh_reader)


def model_from(source: Source) -> SceneModel:
    """Returns the validated model of a scene file or mapping, without reading its other files. Raises SceneError."""
    return model_and_folder(source, None)[0]


def scene_from_model(model: SceneModel, folder: Path | None, mesh_reader: MeshReader = IN_PROCESS) -> Scene:
    """Returns the scene in SI units with its files from `folder`. Raises SceneError with a line for each problem."""
    loader = _Loader(model, SceneFolder(folder), mesh_reader)
    bodies = [body for k in range(len(model.body)) if (body := loader.load_body(k)) is not None]
    if loader.problems:
        raise error_from_problems(loader.problems)
    first, *_ = radars = loader.installations()
    world = World(model.name, loader.origin, first.environment, tuple(bodies))
    loader.warnings.extend(mesh_warnings(loader.findings))
    if loader.origin is not None:
        loader.warnings.extend(distance_warnings(loader.entries, [its.platform for its in radars]))
    terrain = [k for k, body in enumerate(model.body) if body.heightmap is not None]
    for entry, its in zip(loader.entries, radars, strict=True):
        with at_location(entry.location):
            check_echo_power(its.radar, bodies)
            check_antenna(its.radar, its.platform.motion)
        remarks = validity_warnings(world, its.radar, its.platform)
        loader.warnings.extend(located(remark, entry.location) for remark in remarks)
        loader.warnings.extend(placement_warnings(world, its.radar, its.platform, terrain))
    interference = tuple(interferer_from_model(other) for other in model.interference)
    warnings, notes = tuple(dict.fromkeys(loader.warnings)), tuple(mesh_notes(loader.findings))
    return Scene(world, first.radar, first.platform, warnings, interference, notes, first.errors, first.id, tuple(radars))


class _Loader:
    """Builds the bodies of one scene and collects problems and warnings. Bodies share the mesh of the same file or shape."""

    def __init__(self, model: SceneModel, folder: SceneFolder, mesh_reader: MeshReader) -> None:
        self.model, self.folder, self.mesh_reader = model, folder, mesh_reader
        self.problems: dict[str, None] = {}  # in order, each once
        self.warnings: list[str] = []
        self.findings: list[Findings] = []
        self.triangles = 0
        self.meshes: dict[tuple[object, ...], LoadedMesh | SceneError] = {}
        self.origin: Origin | None = None
        if model.origin is not None:
            self.origin = (model.origin.latitude_deg, model.origin.longitude_deg)
        self.motions: dict[int, Motion | SceneError] = {}  # by number of the body
        self.entries = radar_entries(model.radar)
        self.radars = [radar_from_model(entry.model) for entry in self.entries]
        self.environments = [self._collected(partial(environment_from_model, model.environment, r)) for r in self.radars]
        own_ship = self._collected(self._own_ship)
        self.platforms = [own_ship if entry.platform is None else self._platform(entry.platform) for entry in self.entries]

    def installations(self) -> list[Installation]:
        """Returns the radars of a scene without problems."""
        parts = zip(self.entries, self.radars, self.platforms, self.environments, strict=True)
        return [
            Installation(e.id, radar, carrier, around, self._errors(e), has_sensors(e))
            for e, radar, carrier, around in parts
            if carrier and around
        ]

    def load_body(self, k: int) -> Body | None:
        """Returns body k, or None after collecting its problems."""
        return self._collected(partial(self._body, k))

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
        return Platform(motion_from_model(own_ship, start, "own_ship", self._read_track))

    def _platform(self, platform: PlatformModel) -> Platform | None:
        if platform.body is not None:
            return self._collected(partial(self._carrier, platform.body))
        start = self._position(platform.latitude_deg, platform.longitude_deg, 0.0, platform.position_m)
        return Platform(constant_motion(start, platform.heading_deg, None, 0.0))

    def _errors(self, entry: RadarEntry) -> ErrorSettings | None:
        """Returns the errors of a radar: of all, of its platform's sensors and of its own, the nearest last."""
        own_ship = self.model.own_ship
        body = own_ship.body if entry.platform is None else entry.platform.body
        of_platform = [its.errors for its in self.model.body if its.name == body]
        if entry.platform is None or (body is not None and body == own_ship.body):
            of_platform.append(own_ship.errors)
        models = (self.model.errors, *of_platform, entry.model.errors)
        return settings_from_models(*models, has_sensors=has_sensors(entry))

    def _carrier(self, name: str) -> Platform:
        """Returns the body of that name as a platform."""
        return Platform(self._motion([body.name for body in self.model.body].index(name)), name)

    def _motion(self, k: int) -> Motion:
        """Returns the motion of body k, which is no height map; an error is kept too."""
        body = self.model.body[k]
        return _cached(self.motions, k, lambda: motion_from_model(body, self._start(body), f"body[{k}]", self._read_track))

    def _body(self, k: int) -> Body:
        body, location = self.model.body[k], f"body[{k}]"
        material = material_from_name(body.material, f"{location}.material")
        scattering = "rcs" if body.rcs_dbsm is not None else body.scattering or material.scattering
        start = self._start(body)
        if body.heightmap is not None:
            terrain = self._terrain(body, start, location)
            mesh: Mesh | None = terrain.loaded.mesh
            start = terrain.position
            self.findings.append((f"{location}.heightmap", body.heightmap, terrain.loaded.findings))
        else:
            mesh = self._mesh(body, location, SCATTERING_MODELS[scattering])
        self._count(mesh, location)
        motion = self._motion(k) if body.heightmap is None else constant_motion(start, 0.0, 0.0, 0.0)
        rcs = None if body.rcs_dbsm is None else 10.0 ** (body.rcs_dbsm / 10.0)
        beam, length = (0.0, 0.0) if mesh is None else np.ptp(mesh.vertices[:, :2], axis=0).tolist()
        is_vessel = body.shape == "hull" or (body.mesh is not None and material.name in VESSEL_MATERIALS)
        presence = presence_from_model(body, self.radars[0].rotation_period)
        return Body(
            body.name, mesh, motion, material, scattering, rcs, body.swerling, body.mmsi, length, beam, is_vessel, presence,
            one_sided=body.heightmap is not None,
        )  # fmt: skip

    def _start(self, body: BodyModel) -> Floats:
        """Returns the position (3,) [m] of the body in the scene file; by default the origin."""
        return self._position(body.latitude_deg, body.longitude_deg, body.up_m or 0.0, body.position_m)

    def _position(
        self, latitude_deg: float | None, longitude_deg: float | None, up: float, position: tuple[float, ...] | None
    ) -> Floats:
        """Returns a position (3,) [m] that is given in degrees and a height, or on the map; by default the origin."""
        if latitude_deg is not None and longitude_deg is not None and self.origin is not None:
            return np.array([*map_from_geographic(latitude_deg, longitude_deg, self.origin), up])
        return np.array([*(position or ()), 0.0, 0.0, 0.0][:3])

    def _terrain(self, body: BodyModel, start: Floats, location: str) -> Terrain:
        name = str(body.heightmap)
        content = self.folder.read(name, f"{location}.heightmap", MAX_RASTER_BYTES)
        return self.mesh_reader.terrain(
            content, name, body, start, self.origin, Coverage(*reach(self.radars, self.platforms)), location
        )

    def _mesh(self, body: BodyModel, location: str, model: type[ScatteringModel]) -> Mesh | None:
        if body.mesh is not None:
            loaded = self._mesh_file(body, f"{location}.mesh")
            self.findings.append((f"{location}.mesh", body.mesh, (*loaded.findings, *axis_findings(body, loaded.mesh))))
            return loaded.mesh
        if body.shape is None or body.shape == "point":
            return None
        sizes = {key: getattr(body, key) for key in SHAPE_SIZES[body.shape]}
        sag = model.shape_sag(body.shape, min(radar.wavelength for radar in self.radars))
        key = (body.shape, sag, *sizes.values())
        return _cached(self.meshes, key, lambda: LoadedMesh(shape_mesh(str(body.shape), sizes, sag), ())).mesh

    def _mesh_file(self, body: BodyModel, location: str) -> LoadedMesh:
        name = str(body.mesh)

        def load() -> LoadedMesh:
            content = self.folder.read(name, location, MAX_FILE_BYTES)
            return self.mesh_reader.mesh(content, name, f"{location}: {name}", body.scale, body.up)

        return _cached(self.meshes, (name, body.scale, body.up), load)

    def _count(self, mesh: Mesh | None, location: str) -> None:
        self.triangles += 0 if mesh is None else len(mesh.faces)
        if self.triangles > self.mesh_reader.max_triangles:
            raise SceneError(
                f"{location}: the body brings the scene to {self.triangles} triangles; at most "
                f"{self.mesh_reader.max_triangles} are allowed: simplify or remove meshes"
            )

    def _read_track(self, name: str, location: str, heading_deg: float | None) -> Motion:
        content = self.folder.read(name, location, MAX_TRACK_BYTES)
        return motion_from_track(content, f"{location}: {name}", heading_deg, self.origin)


def _cached(made: dict[Key, Made | SceneError], key: Key, make: Callable[[], Made]) -> Made:
    """Returns the result of `make`, called once for each key; an error is kept too."""
    if key not in made:
        try:
            made[key] = make()
        except SceneError as error:
            made[key] = error
    result = made[key]
    if isinstance(result, SceneError):
        raise result
    return result
