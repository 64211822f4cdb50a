"""Readers that turn the mesh files and height maps of a scene into triangles, in this process or in a sandbox."""

from typing import Protocol

from radar_service.scene_file.model.scene import BodyModel
from radar_service.scene_file.readers.heightmap import Coverage, Floats, Terrain, heightmap_terrain
from radar_service.scene_file.readers.mesh import LoadedMesh, mesh_from_bytes
from radar_service.scene_file.readers.raster import raster_from_bytes
from radar_service.world.geo import Origin


class MeshReader(Protocol):
    """Reads meshes and terrains from the bytes of files.

    max_triangles: the most triangles that all bodies of a scene may have together.
    """

    @property
    def max_triangles(self) -> int: ...

    def mesh(self, content: bytes, name: str, location: str, scale: float, up: str) -> LoadedMesh:
        """Returns the mesh in a file; arguments and errors as mesh.mesh_from_bytes."""

    def terrain(
        self, content: bytes, name: str, body: BodyModel, start: Floats, origin: Origin | None, coverage: Coverage,
        location: str,
    ) -> Terrain:  # fmt: skip
        """Returns the terrain in the height map `name`; arguments and errors as heightmap.heightmap_terrain."""


class InProcessReader:
    """Reads files in this process, without limits: for files that the operator of the program trusts."""

    max_triangles = 40_000_000  # some 2 GB as vertices, faces and ray-tracing tree

    def mesh(self, content: bytes, name: str, location: str, scale: float, up: str) -> LoadedMesh:
        """Returns the mesh in a file; arguments and errors as mesh.mesh_from_bytes."""
        return mesh_from_bytes(content, name, location, scale, up)

    def terrain(
        self, content: bytes, name: str, body: BodyModel, start: Floats, origin: Origin | None, coverage: Coverage,
        location: str,
    ) -> Terrain:  # fmt: skip
        """Returns the terrain in the height map `name`; arguments and errors as heightmap.heightmap_terrain."""
        samples = raster_from_bytes(content, name, f"{location}.heightmap: {name}")
        return heightmap_terrain(body, samples, start, origin, coverage, location)


IN_PROCESS = InProcessReader()
