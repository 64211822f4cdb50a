"""Scenes ready to run: the model turned to SI, its meshes, height maps and tracks loaded.

Whatever is wrong ends as a SceneError that names the place, the value, what is allowed and the remedy; nothing else escapes.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from radar_service.constants import EARTH_RADIUS
from radar_service.radar.parameters import Radar
from radar_service.scene import raster
from radar_service.scene.builder import Builder, InProcess
from radar_service.scene.convert import environment_from_model, interferer_from_model, radar_from_model
from radar_service.scene.doubts import check_power, doubts
from radar_service.scene.error import SceneError
from radar_service.scene.faults import limited
from radar_service.scene.files import SceneFolder
from radar_service.scene.geo import Origin, map_from_geographic
from radar_service.scene.heightmap import Sight, Terrain
from radar_service.scene.materials import material_from_name
from radar_service.scene.mesh import MAX_FILE_BYTES, LoadedMesh
from radar_service.scene.model import SHAPE_SIZES, BodyModel, SceneModel
from radar_service.scene.motion import MAX_TRACK_BYTES, motion_from_model
from radar_service.scene.odd_places import odd_places
from radar_service.scene.shapes import shape_mesh
from radar_service.scene.source import Source, model_and_folder
from radar_service.scene.world import Body, Mesh, Motion, Scattering, Scene

Floats = NDArray[np.float64]

FAR_FROM_ORIGIN = 200_000.0  # m; there the azimuthal map is stretched by 0.02 %, and 44 m in 200 km show on no radar
IN_PROCESS = InProcess()


def load_scene(source: Source, *, folder: Path | None = None, builder: Builder = IN_PROCESS) -> Scene:
    """The scene in a TOML or JSON file, or in a mapping of the same form (then its files are looked for in `folder`).

    builder: who parses its meshes and height maps; files of strangers are for scene.sandbox.Sandbox.

    A name that is no file on disk is looked for among the packaged ones: "harbour" and "scenes/harbour.toml" work anywhere.
    Raises SceneError, and nothing else, for whatever cannot be run.
    """
    return scene_from_model(*model_and_folder(source, folder), builder)


def model_from(source: Source) -> SceneModel:
    """The checked model of a scene file or mapping; the files it names are not looked at. Raises SceneError."""
    return model_and_folder(source, None)[0]


def scene_from_model(model: SceneModel, folder: Path | None, builder: Builder = IN_PROCESS) -> Scene:
    """The scene in SI with its files from `folder`. Raises SceneError with up to twenty problems, a line each."""
    loader = _Loader(model, SceneFolder(folder), builder)
    bodies = [body for k in range(len(model.body)) if (body := loader.attempted(k)) is not None]
    if loader.problems:
        raise limited(loader.problems)
    assert loader.own_ship is not None and loader.environment is not None
    check_power(loader.radar, bodies)
    loader.warn_of_distance()
    loader.warnings.extend(doubts(loader.radar, loader.own_ship, bodies))
    scene = Scene(
        model.name, loader.origin, loader.radar, loader.environment, loader.own_ship, tuple(bodies), tuple(loader.warnings),
        tuple(interferer_from_model(other) for other in model.interference),
    )  # fmt: skip
    terrain = [k for k, body in enumerate(model.body) if body.heightmap is not None]
    return replace(scene, warnings=(*scene.warnings, *odd_places(scene, terrain)))


class _Loader:
    """Builds the bodies of one scene, one file or shape once however many bodies share it; gathers problems and warnings."""

    def __init__(self, model: SceneModel, folder: SceneFolder, builder: Builder) -> None:
        self.model, self.folder, self.builder = model, folder, builder
        self.problems: list[str] = []
        self.warnings: list[str] = []
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
        except SceneError as fault:
            self.problems.extend(fault.problems)
        try:
            start = np.array([*model.own_ship.position_m, 0.0])
            self.own_ship = motion_from_model(model.own_ship, start, "own_ship", self._read_track, self.origin)
        except SceneError as fault:
            self.problems.extend(fault.problems)

    def warn_of_distance(self) -> None:
        """Says how far the map is from the earth where own ship lies far from the origin."""
        assert self.own_ship is not None
        far = float(np.hypot(self.own_ship.position[:, 0], self.own_ship.position[:, 1]).max())
        if self.origin is not None and far > FAR_FROM_ORIGIN:
            arc = far / EARTH_RADIUS
            self.warnings.append(
                f"own_ship: {far / 1000:.0f} km from the origin, where the map is stretched by {arc / np.sin(arc) - 1:.2%} "
                "across the line from the origin and its north is not true north: move [origin] nearer"
            )

    def attempted(self, k: int) -> Body | None:
        """Body k, or None with its problems noted."""
        try:
            return self._body(self.model.body[k], f"body[{k}]")
        except SceneError as fault:
            self.problems.extend(fault.problems)
            return None

    def _body(self, body: BodyModel, place: str) -> Body:
        material = material_from_name(body.material, f"{place}.material")
        scattering: Scattering = "rcs" if body.rcs_dbsm is not None else body.scattering or material.scattering
        start = self._start(body)
        if body.heightmap is not None:
            terrain = self._terrain(body, start, place)
            mesh: Mesh | None = terrain.loaded.mesh
            start = terrain.position
            self._warn(f"{place}.heightmap", body.heightmap, terrain.loaded)
        else:
            mesh = self._mesh(body, place, scattering == "optics")
        self._count(mesh, place)
        motion = motion_from_model(body, start, place, self._read_track, self.origin)
        rcs = None if body.rcs_dbsm is None else 10.0 ** (body.rcs_dbsm / 10.0)
        beam, length = (0.0, 0.0) if mesh is None else np.ptp(mesh.vertices[:, :2], axis=0).tolist()
        return Body(body.name, mesh, motion, material, scattering, rcs, body.swerling, body.mmsi, length, beam)

    def _start(self, body: BodyModel) -> Floats:
        """Where the body stands at first (3,) [m]; the origin where nothing is said."""
        if body.latitude_deg is not None and body.longitude_deg is not None and self.origin is not None:
            east, north = map_from_geographic(body.latitude_deg, body.longitude_deg, self.origin)
            return np.array([east, north, body.up_m or 0.0])
        return np.array(body.position_m or (0.0, 0.0, 0.0))

    def _warn(self, place: str, name: str, loaded: LoadedMesh) -> None:
        if loaded.findings:
            self.warnings.append(f"{place}: {name}: {', '.join(loaded.findings)}")

    def _terrain(self, body: BodyModel, start: Floats, place: str) -> Terrain:
        name = str(body.heightmap)
        content = self.folder.read(name, f"{place}.heightmap", raster.MAX_FILE_BYTES)
        return self.builder.terrain(content, name, body, start, self.origin, self._sight(), place)

    def _sight(self) -> Sight:
        """What own ship can see from anywhere on her way; everything, where she goes on for ever."""
        way = np.zeros((1, 3)) if self.own_ship is None else self.own_ship.position
        for_ever = self.own_ship is not None and bool(self.own_ship.final_velocity.any())
        strayed = np.inf if for_ever else float(np.hypot(*(way - way[0])[:, :2].T).max())
        reach = np.inf if self.radar.second_time_around else self.radar.range_max
        return Sight(float(way[0, 0]), float(way[0, 1]), reach + strayed)

    def _mesh(self, body: BodyModel, place: str, optics: bool) -> Mesh | None:
        if body.mesh is not None:
            loaded = self._mesh_file(body, f"{place}.mesh")
            self._warn(f"{place}.mesh", body.mesh, loaded)
            return loaded.mesh
        if body.shape is None or body.shape == "point":
            return None
        sizes = {key: getattr(body, key) for key in SHAPE_SIZES[body.shape]}
        key = (body.shape, optics, *sizes.values())
        return self._once(key, lambda: LoadedMesh(shape_mesh(str(body.shape), sizes, optics), ())).mesh

    def _mesh_file(self, body: BodyModel, place: str) -> LoadedMesh:
        name = str(body.mesh)

        def load() -> LoadedMesh:
            content = self.folder.read(name, place, MAX_FILE_BYTES)
            return self.builder.mesh(content, name, f"{place}: {name}", body.scale, body.up)

        return self._once((name, body.scale, body.up), load)

    def _once(self, key: tuple[object, ...], make: Callable[[], LoadedMesh]) -> LoadedMesh:
        """What `make` makes, made once per key; a failure is remembered too."""
        if key not in self.meshes:
            try:
                self.meshes[key] = make()
            except SceneError as fault:
                self.meshes[key] = fault
        found = self.meshes[key]
        if isinstance(found, SceneError):
            raise found
        return found

    def _count(self, mesh: Mesh | None, place: str) -> None:
        self.triangles += 0 if mesh is None else len(mesh.faces)
        if self.triangles > self.builder.max_triangles:
            raise SceneError(
                f"{place}: brings the scene to {self.triangles} triangles; at most {self.builder.max_triangles}: "
                "simplify or remove some"
            )

    def _read_track(self, name: str, place: str) -> bytes:
        return self.folder.read(name, place, MAX_TRACK_BYTES)
