"""Who turns a scene's files into triangles: this process, or one that is limited (see sandbox)."""

from typing import Protocol

from radar_service.scene import raster
from radar_service.scene.geo import Origin
from radar_service.scene.heightmap import Floats, Sight, Terrain, heightmap_terrain
from radar_service.scene.mesh import LoadedMesh, mesh_from_bytes
from radar_service.scene.model import BodyModel


class Builder(Protocol):
    """Builds meshes and terrains from the bytes of files. max_triangles: of all bodies of a scene together."""

    @property
    def max_triangles(self) -> int: ...

    def mesh(self, content: bytes, name: str, place: str, scale: float, up: str) -> LoadedMesh:
        """As mesh.mesh_from_bytes."""

    def terrain(
        self, content: bytes, name: str, body: BodyModel, start: Floats, origin: Origin | None, sight: Sight, place: str
    ) -> Terrain:
        """The terrain of the height map `name`, else as heightmap.heightmap_terrain."""


class InProcess:
    """Builds here and now: for files that whoever runs the program has chosen."""

    max_triangles = 40_000_000  # some 2 GB as vertices, faces and ray-tracing tree

    def mesh(self, content: bytes, name: str, place: str, scale: float, up: str) -> LoadedMesh:
        """As mesh.mesh_from_bytes."""
        return mesh_from_bytes(content, name, place, scale, up)

    def terrain(
        self, content: bytes, name: str, body: BodyModel, start: Floats, origin: Origin | None, sight: Sight, place: str
    ) -> Terrain:
        """The terrain of the height map `name`, else as heightmap.heightmap_terrain."""
        samples = raster.raster_from_bytes(content, name, f"{place}.heightmap: {name}")
        return heightmap_terrain(body, samples, start, origin, sight, place)
