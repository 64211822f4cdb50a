"""Builds the bodies of a scene from their models: the mesh of each kind, its motion and what it is made of."""

import math
from collections.abc import Callable, Hashable, Sequence
from typing import TypeVar

import numpy as np

from radar_service.numerics import Floats, body_rotation
from radar_service.radar import Radar
from radar_service.scattering import model_named, size_of
from radar_service.scene_file.checks.mesh_findings import (
    Findings,
    axis_findings,
    check_optics_area,
    is_under_way,
    size_findings,
)
from radar_service.scene_file.convert import SeawayBuilder, extent_of, hull_from_model, presence_from_model
from radar_service.scene_file.folder import SceneFolder
from radar_service.scene_file.model.body import (
    REFLECTOR_SIZES,
    BodyModel,
    BodyOfAKind,
    HeightMapBodyModel,
    MeshBodyModel,
    PlatingModel,
    ShapeBodyModel,
)
from radar_service.scene_file.readers.file_format import LoadedBody, MeshReader
from radar_service.scene_file.readers.heightmap import Coverage, HeightMapFile
from radar_service.scene_file.readers.mesh import MAX_FILE_BYTES, MeshFile
from radar_service.scene_file.readers.raster import MAX_FILE_BYTES as MAX_RASTER_BYTES
from radar_service.scene_file.readers.track import MAX_TRACK_BYTES, motion_from_track
from radar_service.scene_file.routes import constant_motion, motion_from_model, start_position
from radar_service.stages.registry import effect_records
from radar_service.world import (
    PLAIN,
    VESSEL_MATERIALS,
    Body,
    Material,
    Mesh,
    Motion,
    Origin,
    Plating,
    Reflector,
    SceneError,
    Stream,
    hull_mesh,
    material_from_name,
    shape_mesh,
)

Result = TypeVar("Result")
Key = TypeVar("Key", bound=Hashable)


class BodyLoader:
    """Builds the bodies of one scene. Bodies share the mesh of the same file or shape.

    models: of the bodies, in their order. A file with several bodies puts its further ones at the end, once read.
    findings: about the files read so far; hints: about sizes and axes of bodies, in the order of the bodies.
    """

    def __init__(
        self, models: Sequence[BodyOfAKind], folder: SceneFolder, mesh_reader: MeshReader, origin: Origin | None,
        radars: Sequence[Radar], stream: Stream, seaway: SeawayBuilder | None = None,
    ) -> None:  # fmt: skip
        self.models, self._folder, self._mesh_reader = list(models), folder, mesh_reader
        self._origin, self._radars, self._stream, self._seaway = origin, radars, stream, seaway
        self.findings: list[Findings] = []
        self.hints: list[Findings] = []
        self._triangles = 0
        self._files: dict[tuple[object, ...], tuple[LoadedBody, ...] | SceneError] = {}
        self._parts: dict[str, tuple[int, str]] = {}  # by name of a body that is one of several: which one, and its key path
        self._placed: dict[tuple[object, ...], Mesh | SceneError] = {}  # meshes of files, turned and moved
        self._shapes: dict[tuple[object, ...], Mesh | SceneError] = {}
        self._motions: dict[int, Motion | SceneError] = {}  # by number of the body

    def motion_of(self, name: str) -> Motion:
        """Returns the motion of the body of that name, which is no height map. Raises SceneError."""
        return self._motion([model.name for model in self.models].index(name))

    def body(self, k: int, coverage: Coverage) -> Body:
        """Returns body k; of a height map, what is inside the coverage. Raises SceneError."""
        location = self._location(k)
        self._divide(k, location)
        model = self.models[k]
        material = material_from_name(model.material, f"{location}.material")
        scattering = _scattering(model, material)
        mesh, position = self._surface(model, location, scattering, coverage)
        self._count(mesh, location)
        if mesh is not None:
            self._judge(model, mesh, material, scattering, location)
        motion = self._motion(k) if position is None else constant_motion(position, 0.0, 0.0, 0.0)
        rcs, reflector = _cross_section(model), _reflector(model)
        beam, length = (0.0, 0.0) if mesh is None else np.ptp(mesh.vertices[:, :2], axis=0).tolist()
        presence = presence_from_model(model, self._radars[0].rotation_period)
        return Body(
            model.name, mesh, motion, material, scattering, rcs, model.swerling, model.mmsi, length, beam,
            _is_vessel(model, material), presence, one_sided=isinstance(model, HeightMapBodyModel),
            plating=_plating(model), reflector=reflector,
            effects=effect_records(model, "body_keys", lambda effect, given: effect.body_record(given, mesh)),
        )  # fmt: skip

    def read_track(self, name: str, location: str, heading_deg: float | None) -> Motion:
        """Returns the motion in a track of the scene's folder. Raises SceneError."""
        content = self._folder.read(name, location, MAX_TRACK_BYTES)
        return motion_from_track(content, f"{location}: {name}", heading_deg, self._origin)

    def _motion(self, k: int) -> Motion:
        model, location = self.models[k], self._location(k)

        def motion_in_seaway() -> Motion:
            motion = motion_from_model(model, self._start(model), location, self.read_track, self._stream)
            return self._in_seaway(motion, model, location)

        return _cached(self._motions, k, motion_in_seaway)

    def _in_seaway(self, motion: Motion, model: BodyOfAKind, location: str) -> Motion:
        """The motion with the sway of the seaway; the same motion for bodies that it does not move."""
        if self._seaway is None or isinstance(model, HeightMapBodyModel):
            return motion
        material = material_from_name(model.material, f"{location}.material")
        if not self._seaway.moves(model, _is_vessel(model, material)):
            return motion
        mesh = self._mesh(model, location, _scattering(model, material))
        form = hull_from_model(model.hull, extent_of(mesh, float(self._start(model)[2])), model.draught_m, location)
        return self._seaway.moved(motion, model, form, model.name)

    def _start(self, model: BodyModel) -> Floats:
        """Returns the position (3,) [m] of the body in the scene file; by default the origin."""
        up = model.up_m or 0.0
        return start_position(model.latitude_deg, model.longitude_deg, up, model.position_m, self._origin)

    def _surface(
        self, model: BodyOfAKind, location: str, scattering: str, coverage: Coverage
    ) -> tuple[Mesh | None, Floats | None]:
        """Returns the mesh of a body, None for a point, and its position (3,) [m] where its file tells it."""
        if isinstance(model, HeightMapBodyModel):
            return self._height_map(model, location, coverage)
        return self._mesh(model, location, scattering), None

    def _mesh(self, model: ShapeBodyModel | MeshBodyModel, location: str, scattering: str) -> Mesh | None:
        """The mesh of a body that is no height map, None for a point."""
        if isinstance(model, ShapeBodyModel):
            return self._shape(model, scattering)
        return self._mesh_file(model, f"{location}.mesh")

    def _shape(self, model: ShapeBodyModel, scattering: str) -> Mesh | None:
        if model.shape in ("point", "reflector"):
            return None
        sizes = model.sizes()
        if model.shape == "hull":
            kind, seed = model.hull_type or PLAIN, model.hull_seed or 0
            return _cached(self._shapes, (kind, seed, *sizes.values()), lambda: hull_mesh(kind, seed, *sizes.values()))
        sag = model_named(scattering).shape_sag(model.shape, min(radar.wavelength for radar in self._radars))
        key = (model.shape, sag, *sizes.values())
        return _cached(self._shapes, key, lambda: shape_mesh(model.shape, sizes, sag))

    def _location(self, k: int) -> str:
        """The key path of body k."""
        return self._parts.get(self.models[k].name, (0, f"body[{k}]"))[1]

    def _divide(self, k: int, location: str) -> None:
        """Makes several bodies of body k where its file has several, each with a model. Raises SceneError for one that moves."""
        model = self.models[k]
        if not isinstance(model, MeshBodyModel) or model.name in self._parts:
            return
        parts = self._loaded(model, f"{location}.mesh")
        if len(parts) == 1 and parts[0].position is None:
            return
        if is_under_way(model) or model.steerable:
            raise SceneError(f"{location}.mesh: the file has {len(parts)} bodies, which cannot move; let the body rest")
        heading = (model.course_deg or 0.0) if model.heading_deg is None else model.heading_deg
        start, turned = self._start(model), body_rotation(math.radians(heading - model.mesh_heading_deg))
        for number, part in enumerate(parts):
            place = start if part.position is None else start + turned @ part.position
            keys = dict.fromkeys(("latitude_deg", "longitude_deg", "up_m")) | {"position_m": tuple(place.tolist())}
            if number:
                keys |= {"name": f"{model.name} {part.name or number + 1}", "mmsi": None}
            copy = model.model_copy(update=keys)
            if number and any(other.name == copy.name for other in self.models):
                raise SceneError(f'{location}.mesh: the file has "{copy.name}", which another body is called; rename one')
            self._parts[copy.name] = number, location
            if number:
                self.models.append(copy)
            else:
                self.models[k] = copy

    def _loaded(self, model: MeshBodyModel, location: str) -> tuple[LoadedBody, ...]:
        """The bodies in the file of a body."""
        scale, up = (getattr(model, key) if key in model.model_fields_set else None for key in ("scale", "up"))

        def load() -> tuple[LoadedBody, ...]:
            content = self._folder.read(model.mesh, location, MAX_FILE_BYTES)
            return self._mesh_reader.read(MeshFile(content, model.mesh, f"{location}: {model.mesh}", scale, up))

        return _cached(self._files, (model.mesh, scale, up), load)

    def _mesh_file(self, model: MeshBodyModel, location: str) -> Mesh:
        number = self._parts.get(model.name, (0,))[0]
        loaded = self._loaded(model, location)[number]
        heading, offset = math.radians(model.mesh_heading_deg), np.array(model.mesh_offset_m)
        key = (id(loaded), heading, model.mesh_offset_m)
        self.findings.append((location, model.mesh, loaded.findings))
        return _cached(self._placed, key, lambda: loaded.mesh.placed(heading, offset))

    def _height_map(self, model: HeightMapBodyModel, location: str, coverage: Coverage) -> tuple[Mesh, Floats | None]:
        key, name = f"{location}.heightmap", model.heightmap
        content = self._folder.read(name, key, MAX_RASTER_BYTES)
        # no key of a package in the sandbox:
        plain = HeightMapBodyModel.model_construct(model.model_fields_set, **dict(model))
        file = HeightMapFile(content, name, plain, self._start(model), self._origin, coverage, location)
        (body,) = self._mesh_reader.read(file)
        self.findings.append((key, name, body.findings))
        return body.mesh, body.position

    def _judge(self, model: BodyOfAKind, mesh: Mesh, material: Material, scattering: str, location: str) -> None:
        """Keeps hints about the size and the axes of a body. Raises SceneError for one that is too large to be computed."""
        size = np.ptp(mesh.vertices, axis=0)
        if not isinstance(model, HeightMapBodyModel):
            hints = [*size_findings(model, size, _is_vessel(model, material) or is_under_way(model))]
            if isinstance(model, MeshBodyModel):
                hints += axis_findings(model, mesh, float(self._start(model)[2]))
                self.hints.append((f"{location}.mesh", model.mesh, hints))
            else:
                self.hints.append((location, model.name, hints))
        if scattering == "optics":
            check_optics_area(model, mesh, size, location)

    def _count(self, mesh: Mesh | None, location: str) -> None:
        self._triangles += 0 if mesh is None else len(mesh.faces)
        if self._triangles > self._mesh_reader.max_triangles:
            raise SceneError(
                f"{location}: the body brings the scene to {self._triangles} triangles; at most "
                f"{self._mesh_reader.max_triangles} are allowed: simplify or remove meshes"
            )


def _cross_section(model: BodyOfAKind) -> float | None:
    """The declared cross-section [m^2] that holds at all frequencies; a reflector has none."""
    return None if model.rcs_dbsm is None or _is_reflector(model) else 10.0 ** (model.rcs_dbsm / 10.0)


def _reflector(model: BodyOfAKind) -> Reflector | None:
    """The reflector that a body is; its size by the peak of its lobes where the file tells that."""
    if not isinstance(model, ShapeBodyModel) or model.reflector is None:
        return None
    if model.rcs_dbsm is not None:
        return Reflector(model.reflector, size_of(model.reflector, 10.0 ** (model.rcs_dbsm / 10.0)), model.hung)
    return Reflector(model.reflector, getattr(model, REFLECTOR_SIZES[model.reflector]), model.hung)


def _is_reflector(model: BodyOfAKind) -> bool:
    return isinstance(model, ShapeBodyModel) and model.shape == "reflector"


def _scattering(model: BodyOfAKind, material: Material) -> str:
    if _is_reflector(model):
        return "reflector"
    return "rcs" if model.rcs_dbsm is not None else model.scattering or material.scattering


def _plating(model: BodyOfAKind) -> Plating | None:
    """How the walls of a body are dented; those of hull types other than `plain` by default."""
    drawn = isinstance(model, ShapeBodyModel) and model.hull_type not in (None, PLAIN)
    table = model.plating or (PlatingModel() if drawn else None)
    return None if table is None else Plating(table.dent_m, table.frame_m, table.panel_height_m, table.seed)


def _is_vessel(model: BodyOfAKind, material: Material) -> bool:
    if isinstance(model, ShapeBodyModel):
        return model.shape == "hull"
    return isinstance(model, MeshBodyModel) and material.name in VESSEL_MATERIALS


def _cached(known: dict[Key, Result | SceneError], key: Key, make: Callable[[], Result]) -> Result:
    """Returns the result of `make`, called once for each key; an error is kept too."""
    if key not in known:
        try:
            known[key] = make()
        except SceneError as error:
            known[key] = error
    result = known[key]
    if isinstance(result, SceneError):
        raise result
    return result
