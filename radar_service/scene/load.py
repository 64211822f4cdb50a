"""Loads a scene: converts the model to SI units and reads its meshes, height maps and tracks.

Every problem raises a SceneError with the key, the value, the allowed range and the remedy; no other error is raised.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from radar_service.constants import EARTH_RADIUS
from radar_service.radar.parameters import Radar
from radar_service.scene.body import Body, Mesh, Scattering
from radar_service.scene.checks.mesh_findings import Findings, mesh_notes, mesh_warnings
from radar_service.scene.checks.placement import placement_warnings
from radar_service.scene.checks.validity import check_antenna, check_echo_power, validity_warnings
from radar_service.scene.convert import environment_from_model, interferer_from_model, presence_from_model, radar_from_model
from radar_service.scene.error import SceneError
from radar_service.scene.files.heightmap import Coverage, Terrain
from radar_service.scene.files.mesh import MAX_FILE_BYTES, LoadedMesh
from radar_service.scene.files.mesh_reader import IN_PROCESS, MeshReader
from radar_service.scene.files.raster import MAX_FILE_BYTES as MAX_RASTER_BYTES
from radar_service.scene.files.scene_file import Source, model_and_folder
from radar_service.scene.files.scene_folder import SceneFolder
from radar_service.scene.files.track import MAX_TRACK_BYTES, motion_from_track
from radar_service.scene.geo import Origin, map_from_geographic
from radar_service.scene.materials import VESSEL_MATERIALS, material_from_name
from radar_service.scene.model import SHAPE_SIZES, BodyModel, SceneModel
from radar_service.scene.motion import Motion
from radar_service.scene.platform import Platform
from radar_service.scene.routes import motion_from_model
from radar_service.scene.shapes import shape_mesh
from radar_service.scene.validation_messages import error_from_problems
from radar_service.scene.world import Scene, World

Floats = NDArray[np.float64]

MAX_ORIGIN_DISTANCE = 200_000.0  # m; there the map is stretched by 0.02 %: 44 m in 200 km, below radar accuracy


def load_scene(source: Source, *, folder: Path | None = None, mesh_reader: MeshReader = IN_PROCESS) -> Scene:
    """Returns the scene in a TOML or JSON file, or in a mapping of the same form.

    source: a path, the name of a packaged scene ("harbour" and "scenes/harbour.toml" work in any folder), or a mapping.
    folder: the folder of its meshes, height maps and tracks; by default that of the file. mesh_reader: reads meshes and
    height maps; use files.sandbox.Sandbox for untrusted files. Raises only SceneError.
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
    assert loader.own_ship is not None and loader.environment is not None
    world = World(model.name, loader.origin, loader.environment, tuple(bodies))
    platform = Platform(loader.own_ship)
    check_echo_power(loader.radar, bodies)
    check_antenna(loader.radar, loader.own_ship)
    loader.warnings.extend(mesh_warnings(loader.findings))
    loader.warn_of_distance()
    loader.warnings.extend(validity_warnings(world, loader.radar, platform))
    terrain = [k for k, body in enumerate(model.body) if body.heightmap is not None]
    loader.warnings.extend(placement_warnings(world, loader.radar, platform, terrain))
    interference = tuple(interferer_from_model(other) for other in model.interference)
    notes = tuple(mesh_notes(loader.findings))
    return Scene(world, loader.radar, platform, tuple(loader.warnings), interference, notes)


class _Loader:
    """Builds the bodies of one scene and collects problems and warnings. Bodies share the mesh of the same file or shape."""

    def __init__(self, model: SceneModel, folder: SceneFolder, mesh_reader: MeshReader) -> None:
        self.model, self.folder, self.mesh_reader = model, folder, mesh_reader
        self.problems: list[str] = []
        self.warnings: list[str] = []
        self.findings: list[Findings] = []
        self.triangles = 0
        self.meshes: dict[tuple[object, ...], LoadedMesh | SceneError] = {}
        self.origin: Origin | None = None
        if model.origin is not None:
            self.origin = (model.origin.latitude_deg, model.origin.longitude_deg)
        self.radar: Radar = radar_from_model(model.radar)
        self.own_ship: Motion | None = None
        self.environment = None
        try:
            self.environment = environment_from_model(model.environment, self.radar)
        except SceneError as error:
            self.problems.extend(error.problems)
        try:
            start = np.array([*model.own_ship.position_m, 0.0])
            self.own_ship = motion_from_model(model.own_ship, start, "own_ship", self._read_track)
        except SceneError as error:
            self.problems.extend(error.problems)

    def warn_of_distance(self) -> None:
        """Adds a warning with the distortion of the map if own ship is far from the origin."""
        assert self.own_ship is not None
        distance = float(np.hypot(self.own_ship.position[:, 0], self.own_ship.position[:, 1]).max())
        if self.origin is not None and distance > MAX_ORIGIN_DISTANCE:
            arc = distance / EARTH_RADIUS
            self.warnings.append(
                f"own_ship: at {distance / 1000:.0f} km from the origin the map is stretched by {arc / np.sin(arc) - 1:.2%} "
                "across the line from the origin and its north is not true north: move [origin] nearer"
            )

    def load_body(self, k: int) -> Body | None:
        """Returns body k, or None after collecting its problems."""
        try:
            return self._body(self.model.body[k], f"body[{k}]")
        except SceneError as error:
            self.problems.extend(error.problems)
            return None

    def _body(self, body: BodyModel, location: str) -> Body:
        material = material_from_name(body.material, f"{location}.material")
        scattering: Scattering = "rcs" if body.rcs_dbsm is not None else body.scattering or material.scattering
        start = self._start(body)
        if body.heightmap is not None:
            terrain = self._terrain(body, start, location)
            mesh: Mesh | None = terrain.loaded.mesh
            start = terrain.position
            self._note_findings(f"{location}.heightmap", body.heightmap, terrain.loaded)
        else:
            mesh = self._mesh(body, location, self.radar.wavelength if scattering == "optics" else None)
        self._count(mesh, location)
        motion = motion_from_model(body, start, location, self._read_track)
        rcs = None if body.rcs_dbsm is None else 10.0 ** (body.rcs_dbsm / 10.0)
        beam, length = (0.0, 0.0) if mesh is None else np.ptp(mesh.vertices[:, :2], axis=0).tolist()
        is_vessel = body.shape == "hull" or (body.mesh is not None and material.name in VESSEL_MATERIALS)
        presence = presence_from_model(body, self.radar.rotation_period)
        return Body(
            body.name, mesh, motion, material, scattering, rcs, body.swerling, body.mmsi, length, beam, is_vessel, presence
        )  # fmt: skip

    def _start(self, body: BodyModel) -> Floats:
        """Returns the position (3,) [m] of the body in the scene file; by default the origin."""
        if body.latitude_deg is not None and body.longitude_deg is not None and self.origin is not None:
            east, north = map_from_geographic(body.latitude_deg, body.longitude_deg, self.origin)
            return np.array([east, north, body.up_m or 0.0])
        return np.array(body.position_m or (0.0, 0.0, 0.0))

    def _note_findings(self, location: str, name: str, loaded: LoadedMesh) -> None:
        self.findings.append((location, name, loaded.findings))

    def _terrain(self, body: BodyModel, start: Floats, location: str) -> Terrain:
        name = str(body.heightmap)
        content = self.folder.read(name, f"{location}.heightmap", MAX_RASTER_BYTES)
        return self.mesh_reader.terrain(content, name, body, start, self.origin, self._coverage(), location)

    def _coverage(self) -> Coverage:
        """Returns the area that the radar can reach from all positions of own ship; unlimited if she never stops."""
        knots = np.zeros((1, 3)) if self.own_ship is None else self.own_ship.position
        endless = self.own_ship is not None and bool(self.own_ship.final_velocity.any())
        travel = np.inf if endless else float(np.hypot(*(knots - knots[0])[:, :2].T).max())
        max_range = np.inf if self.radar.second_time_around else self.radar.range_max
        return Coverage(float(knots[0, 0]), float(knots[0, 1]), max_range + travel)

    def _mesh(self, body: BodyModel, location: str, wavelength: float | None) -> Mesh | None:
        if body.mesh is not None:
            loaded = self._mesh_file(body, f"{location}.mesh")
            self._note_findings(f"{location}.mesh", body.mesh, loaded)
            return loaded.mesh
        if body.shape is None or body.shape == "point":
            return None
        sizes = {key: getattr(body, key) for key in SHAPE_SIZES[body.shape]}
        key = (body.shape, wavelength, *sizes.values())
        return self._cached(key, lambda: LoadedMesh(shape_mesh(str(body.shape), sizes, wavelength), ())).mesh

    def _mesh_file(self, body: BodyModel, location: str) -> LoadedMesh:
        name = str(body.mesh)

        def load() -> LoadedMesh:
            content = self.folder.read(name, location, MAX_FILE_BYTES)
            return self.mesh_reader.mesh(content, name, f"{location}: {name}", body.scale, body.up)

        return self._cached((name, body.scale, body.up), load)

    def _cached(self, key: tuple[object, ...], make: Callable[[], LoadedMesh]) -> LoadedMesh:
        """Returns the result of `make`, called once for each key; an error is cached too."""
        if key not in self.meshes:
            try:
                self.meshes[key] = make()
            except SceneError as error:
                self.meshes[key] = error
        result = self.meshes[key]
        if isinstance(result, SceneError):
            raise result
        return result

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
