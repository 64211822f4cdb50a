"""What a format of files is here: how a file of it is recognised, checked and parsed; and what reads the files of a scene."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, Literal, NamedTuple, Protocol, TypeVar

from radar_service.numerics import Floats, Indices
from radar_service.world import Mesh, SceneError

Faces = Indices
Triangles = tuple[Floats, Faces]  # vertices (V, 3) in units of the file, faces (F, 3)
Content = TypeVar("Content")

MAX_FACES = 5_000_000


class FileBody(NamedTuple):
    """One of several bodies in a file, in its units and axes.

    vertices: (V, 3) from `position`, faces (F, 3).
    name: "" for its number; position: (3,), from the place that the scene gives.
    """

    vertices: Floats
    faces: Faces
    name: str = ""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)


def accept(content: bytes, location: str) -> None:
    """Accepts formats that declare no counts, so that the size of the file limits what a parser builds."""


@dataclass(frozen=True)
class Format(Generic[Content]):
    """A format of mesh files, whose content is Triangles or a list of FileBody, or of height maps, whose content is a Raster.

    name: in messages.
    detect: whether bytes look like it.
    parse: returns the content of (bytes, location); location begins messages.
    examples: small files, with which a sandbox loads what the parser needs before its limits apply.
    check: raises SceneError where (bytes, location) declare more than they hold or than is allowed, before they are parsed.
        Other errors of both are refusals too, but for MemoryError.
    up: the axis of the file that points up.
    unit: metres per unit of the file.
    is_plain_text: whether it has no mark of its own, so that files are compared with all others first.
    """

    name: str
    detect: Callable[[bytes], bool]
    parse: Callable[[bytes, str], Content]
    examples: Callable[[], tuple[bytes, ...]]
    check: Callable[[bytes, str], None] = accept
    up: Literal["z", "y"] = "z"
    unit: float = 1.0
    is_plain_text: bool = False


def check_face_count(count: int, location: str) -> None:
    """Raises SceneError above MAX_FACES."""
    if count > MAX_FACES:
        raise SceneError(f"{location}: the mesh has {count} triangles; at most {MAX_FACES} are allowed: simplify it")


def check_range(vertices: Floats, faces: Faces, location: str) -> None:
    """Raises SceneError unless vertices are points in space, to which faces refer."""
    if len(faces) and (vertices.ndim != 2 or vertices.shape[1] != 3):
        raise SceneError(f"{location}: the vertices are not points in space; export the file again")
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise SceneError(
            f"{location}: faces refer to vertices {int(faces.min())} to {int(faces.max())}, but there are only "
            f"{len(vertices)} (counted from 0); export the file again"
        )


@contextmanager
def refusals(name: str, location: str) -> Iterator[None]:
    """Raises SceneError for what the parser of the format `name` raises in the `with` block, whose bytes are arbitrary."""
    try:
        yield
    except (SceneError, MemoryError):
        raise
    except Exception as error:
        text = " ".join(str(error).split())
        reason = f"{type(error).__name__}: {text[:120]}" if text else type(error).__name__
        raise SceneError(f"{location}: the file is not readable as {name.upper()} ({reason}); export it again") from None


class LoadedBody(NamedTuple):
    """What a file gives for a body.

    mesh: usable, in its own frame.
    findings: its defects in words without a subject, for warnings.
    position: (3,) [m] of the frame's origin: on the map for a height map, from the place of the mesh in the scene for one of
        several bodies; None: at that place.
    name: of one of several bodies, where the file tells it.
    """

    mesh: Mesh
    findings: tuple[str, ...]
    position: Floats | None = None
    name: str = ""


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
