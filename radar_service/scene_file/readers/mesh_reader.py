"""Readers that turn the mesh files and height maps of a scene into triangles, in this process or in a sandbox."""

from typing import Protocol

from radar_service.scene_file.readers.heightmap import HeightMapFile
from radar_service.scene_file.readers.mesh import LoadedBody, MeshFile

FILES = (MeshFile, HeightMapFile)  # all kinds of BodyFile


class BodyFile(Protocol):
    """A file with bodies that is to be read: its content, and what the scene says of it.

    location: key path and name of the file, with which messages begin.
    max_bodies: how many it may hold. placed: whether it tells their positions.
    """

    @property
    def location(self) -> str: ...

    @property
    def content(self) -> bytes: ...

    @property
    def max_bodies(self) -> int: ...

    @property
    def placed(self) -> bool: ...

    def read(self) -> tuple[LoadedBody, ...]:
        """Returns its bodies. Raises SceneError if there is no usable one."""


class MeshReader(Protocol):
    """Reads the bodies in files. max_triangles: the most triangles that all bodies of a scene may have together."""

    @property
    def max_triangles(self) -> int: ...

    def read(self, file: BodyFile) -> tuple[LoadedBody, ...]:
        """Returns the bodies in a file. Raises SceneError if there is no usable one."""


class InProcessReader:
    """Reads files in this process, without limits: for files that the operator of the program trusts."""

    max_triangles = 40_000_000  # some 2 GB as vertices, faces and ray-tracing tree

    def read(self, file: BodyFile) -> tuple[LoadedBody, ...]:
        """Returns the bodies in a file. Raises SceneError if there is no usable one."""
        return file.read()


IN_PROCESS = InProcessReader()
