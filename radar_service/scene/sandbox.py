"""Files of strangers are parsed in a child process that can neither take the machine nor reach anything.

Bytes go in, arrays come out. The child (sandbox_child) limits itself before it reads its first file: memory, processor
time, no new file, socket or process. What it answers is checked here as if it came from a stranger. A child that dies,
stalls or has reached a limit is replaced.
"""

import contextlib
import json
import math
import os
import pickle
import struct
import subprocess
import sys
import threading
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from radar_service.scene.error import SceneError
from radar_service.scene.geo import Origin
from radar_service.scene.heightmap import Floats, Sight, Terrain
from radar_service.scene.mesh import REACH, LoadedMesh
from radar_service.scene.model import BodyModel
from radar_service.scene.world import Mesh

MEMORY = 2 * 2**30  # bytes beyond what the interpreter takes; an STL of 64 MiB needs 1.2 GiB
PROCESSOR = 10.0  # s a file
PATIENCE = 30.0  # s of wall clock a file, the child's start of about a second included
MAX_TRIANGLES = 4_000_000  # of a scene: some 300 MB with their ray-tracing tree
MAX_HEAD = 2**20  # bytes of an answer's text
CPU_EXIT = -24  # exit status of a process ended by SIGXCPU
DTYPES = {"vertices": "<f8", "faces": "<i8", "position": "<f8"}


class Sandbox:
    """A builder (see builder.Builder) in a child process, one file at a time. Close it when done.

    memory [bytes] and processor [s] are the child's limits, patience [s of wall clock] the parent's. The child starts with
    the first file, or earlier by `warm`.
    """

    max_triangles = MAX_TRIANGLES

    def __init__(self, memory: int = MEMORY, processor: float = PROCESSOR, patience: float = PATIENCE) -> None:
        self._limits = (memory, processor)
        self._patience = patience
        self._turn = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None

    def warm(self) -> None:
        """Start the child, so that the first file does not wait for it."""
        with self._turn:
            self._alive()

    def close(self) -> None:
        """End the child."""
        with self._turn:
            self._end()

    def mesh(self, content: bytes, name: str, place: str, scale: float, up: str) -> LoadedMesh:
        """As mesh.mesh_from_bytes. Raises SceneError also where the limits are reached."""
        arrays, findings = self._ask(place, ("mesh", content, name, place, scale, up))
        return LoadedMesh(_mesh(arrays, place), findings)

    def terrain(
        self, content: bytes, name: str, body: BodyModel, start: Floats, origin: Origin | None, sight: Sight, place: str
    ) -> Terrain:
        """The terrain of the height map `name`, as heightmap.heightmap_terrain. Raises SceneError at the limits too."""
        where = f"{place}.heightmap: {name}"
        arrays, findings = self._ask(where, ("terrain", content, name, body, start, origin, sight, place))
        position = arrays["position"]
        if position.shape != (3,) or not np.isfinite(position).all():
            raise SceneError(f"{where}: its reader answered nonsense; export it again")
        return Terrain(LoadedMesh(_mesh(arrays, where), findings), position)

    def _ask(self, place: str, request: tuple[Any, ...]) -> tuple[dict[str, NDArray[Any]], tuple[str, ...]]:
        with self._turn:
            child, late = self._alive(), threading.Event()

            def cut_off() -> None:
                late.set()
                child.kill()

            watch = threading.Timer(self._patience, cut_off)
            watch.start()
            try:
                head, arrays = _exchange(child, pickle.dumps(request))
            except (OSError, ValueError, LookupError, TypeError, AttributeError, struct.error):
                self._end()
                reason = self._reason(child.returncode, late.is_set())
                raise SceneError(f"{place}: {reason}; make it smaller or export it again") from None
            finally:
                watch.cancel()
            if head.get("spent"):
                self._end()
                self._alive()
        if head["problems"]:
            raise SceneError(*(str(line)[:2000] for line in head["problems"][:20]))
        return arrays, tuple(str(line)[:500] for line in head["findings"][:20])

    def _alive(self) -> subprocess.Popen[bytes]:
        """The child, begun where there is none."""
        if self._child is None or self._child.poll() is not None:
            self._child = self._begin()
        return self._child

    def _begin(self) -> subprocess.Popen[bytes]:
        path = os.pathsep.join(os.path.abspath(place) for place in sys.path)
        kept = {key: os.environ[key] for key in ("SYSTEMROOT",) if key in os.environ}  # Windows starts nothing without
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "radar_service.scene.sandbox_child", *map(str, self._limits)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            env=kept | {"PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )  # fmt: skip

    def _end(self) -> None:
        child, self._child = self._child, None
        if child is None:
            return
        child.kill()
        for pipe in (child.stdin, child.stdout):
            with contextlib.suppress(OSError):  # what was still to be written finds nobody
                assert pipe is not None
                pipe.close()
        child.wait()

    def _reason(self, status: int, late: bool) -> str:
        """What a child died of."""
        if late or status == CPU_EXIT:
            return f"reading it takes more than {self._limits[1]:g} s of computing"
        return f"reading it takes more than {self._limits[0] / 2**20:.0f} MiB, or breaks its reader"


def _exchange(child: subprocess.Popen[bytes], request: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Ask, and read head and arrays. Raises all sorts where the child ends or answers what no child of ours does."""
    assert child.stdin is not None and child.stdout is not None
    child.stdin.write(struct.pack("<Q", len(request)) + request)
    child.stdin.flush()
    (size,) = struct.unpack("<Q", _read(child.stdout, 8))
    if size > MAX_HEAD:
        raise ValueError("answer too long")
    head = json.loads(_read(child.stdout, size))
    arrays = {}
    for key, shape in head["arrays"].items():
        rows = [int(side) for side in shape]
        if rows[1:] not in ([], [3]) or not 0 <= rows[0] <= 3 * MAX_TRIANGLES:
            raise ValueError("answer of an odd shape")
        data = _read(child.stdout, 8 * math.prod(rows))
        arrays[key] = np.frombuffer(data, DTYPES[key]).reshape(rows).copy()
    return head, arrays


def _read(pipe: IO[bytes], size: int) -> bytes:
    data = pipe.read(size)
    if len(data) < size:
        raise OSError("the child has ended")
    return data


def _mesh(arrays: dict[str, NDArray[Any]], place: str) -> Mesh:
    """The mesh in an answer. Raises SceneError where it is not one."""
    vertices, faces = arrays.get("vertices", np.zeros(0)), arrays.get("faces", np.zeros(0))
    if (
        vertices.ndim != 2 or faces.ndim != 2 or len(faces) == 0 or len(faces) > MAX_TRIANGLES
        or not (np.abs(vertices) <= 2 * REACH).all() or faces.min() < 0 or faces.max() >= len(vertices)
    ):  # fmt: skip
        raise SceneError(f"{place}: its reader answered nonsense; export it again")
    return Mesh(vertices, faces)
