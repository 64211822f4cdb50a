"""Parses untrusted files in a child process that has limited resources and no access to files or the network.

The child receives bytes and returns arrays. The child (sandbox_child) limits itself before it reads its first file:
memory, processor time, no new file, socket or process. This module checks each answer, because a parser may be
compromised. A child that ends, stalls or reaches a limit is replaced.
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
from collections.abc import Sequence
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics.constants import MAX_COORDINATE
from radar_service.processes.processor_time import BACKSTOP, MAX_PROCESSOR_TIME, machine_busy
from radar_service.scene_file.model.scene import BodyModel
from radar_service.scene_file.readers.heightmap import Coverage, Floats, Terrain
from radar_service.scene_file.readers.mesh import LoadedMesh
from radar_service.world.body import Mesh
from radar_service.world.error import SceneError
from radar_service.world.geo import Origin

MAX_MEMORY = 2 * 2**30  # bytes above the interpreter's own; an STL of 64 MiB needs 1.2 GiB
MAX_TRIANGLES = 4_000_000  # of a scene: some 300 MB with their ray-tracing tree
MAX_HEADER_BYTES = 2**20  # of an answer
CPU_TIME_STATUS = -24  # exit status of a process that SIGXCPU ended
CHILD = "radar_service.scene_file.readers.sandbox_child"
DTYPES = {"vertices": "<f8", "faces": "<i8", "position": "<f8"}


class Sandbox:
    """A mesh_reader.MeshReader that reads files in a child process, one at a time. Call `close` after use.

    memory: limit of the child [bytes above the interpreter's own]. processor_time: limit of the child [s per file], from the
    beginning of its parsing. backstop: wall-clock time after which the parent ends the child [s per file]; it includes the
    child's start. command: the program that answers, with its arguments; by default sandbox_child. The child starts with the
    first file, or earlier by `start`.
    """

    max_triangles = MAX_TRIANGLES

    def __init__(
        self, memory: int = MAX_MEMORY, processor_time: float = MAX_PROCESSOR_TIME, backstop: float = BACKSTOP,
        command: Sequence[str] | None = None,
    ) -> None:  # fmt: skip
        self._memory, self._processor_time, self._backstop = memory, processor_time, backstop
        self._command = command or [sys.executable, "-P", "-m", CHILD, str(memory), str(processor_time)]
        self._lock = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Starts the child, so that the first file does not wait for it."""
        with self._lock:
            self._running_child()

    def close(self) -> None:
        """Ends the child."""
        with self._lock:
            self._end()

    def mesh(self, content: bytes, name: str, location: str, scale: float, up: str) -> LoadedMesh:
        """Returns the mesh in a file, as mesh.mesh_from_bytes.

        Raises SceneError also at the limits of the child, and MachineBusyError at the backstop.
        """
        arrays, findings = self._request(location, ("mesh", content, name, location, scale, up))
        return LoadedMesh(mesh_from_answer(arrays, location), findings)

    def terrain(
        self,
        content: bytes,
        name: str,
        body: BodyModel,
        start: Floats,
        origin: Origin | None,
        coverage: Coverage,
        location: str,
    ) -> Terrain:
        """Returns the terrain in a height map, as heightmap.heightmap_terrain. Raises as `mesh`."""
        file_location = f"{location}.heightmap: {name}"
        arrays, findings = self._request(file_location, ("terrain", content, name, body, start, origin, coverage, location))
        position = arrays["position"]
        if position.shape != (3,) or not np.isfinite(position).all():
            raise SceneError(f"{file_location}: the parser returned an invalid answer; export the file again")
        return Terrain(LoadedMesh(mesh_from_answer(arrays, file_location), findings), position)

    def _request(self, location: str, request: tuple[Any, ...]) -> tuple[dict[str, NDArray[Any]], tuple[str, ...]]:
        with self._lock:
            child, timed_out = self._running_child(), threading.Event()

            def end_child() -> None:
                timed_out.set()
                child.kill()

            timer = threading.Timer(self._backstop, end_child)
            timer.start()
            try:
                header, arrays = _exchange(child, pickle.dumps(request))
            except (OSError, ValueError, LookupError, TypeError, AttributeError, struct.error):
                self._end()
                if timed_out.is_set():
                    raise machine_busy(location, self._backstop) from None
                reason = self._reason(child.returncode)
                raise SceneError(f"{location}: {reason}; make it smaller or export it again") from None
            finally:
                timer.cancel()
            if header.get("exhausted"):
                self._end()
                self._running_child()
        if header["problems"]:
            raise SceneError(*(str(line)[:2000] for line in header["problems"][:20]))
        return arrays, tuple(str(line)[:500] for line in header["findings"][:20])

    def _running_child(self) -> subprocess.Popen[bytes]:
        """Returns the child; starts one if none is running."""
        if self._child is None or self._child.poll() is not None:
            self._child = self._start_child()
        return self._child

    def _start_child(self) -> subprocess.Popen[bytes]:
        path = os.pathsep.join(os.path.abspath(folder) for folder in sys.path)
        inherited = {key: os.environ[key] for key in ("SYSTEMROOT",) if key in os.environ}  # Windows needs it
        return subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            env=inherited | {"PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )  # fmt: skip

    def _end(self) -> None:
        child, self._child = self._child, None
        if child is None:
            return
        child.kill()
        for pipe in (child.stdin, child.stdout):
            with contextlib.suppress(OSError):  # unwritten data has no reader any more
                assert pipe is not None
                pipe.close()
        child.wait()

    def _reason(self, status: int) -> str:
        """Returns in words why the child ended."""
        if status == CPU_TIME_STATUS:
            return f"the file takes more than {self._processor_time:g} s of processor time to read"
        return f"the file takes more than {self._memory / 2**20:.0f} MiB to read, or crashes its parser"


def _exchange(child: subprocess.Popen[bytes], request: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Sends a request, returns header and arrays. Raises errors of many types if the child ends or its answer is invalid."""
    assert child.stdin is not None and child.stdout is not None
    child.stdin.write(struct.pack("<Q", len(request)) + request)
    child.stdin.flush()
    (size,) = struct.unpack("<Q", _read(child.stdout, 8))
    if size > MAX_HEADER_BYTES:
        raise ValueError("the answer is too long")
    header = json.loads(_read(child.stdout, size))
    arrays = {}
    for key, shape in header["arrays"].items():
        rows = [int(side) for side in shape]
        if rows[1:] not in ([], [3]) or not 0 <= rows[0] <= 3 * MAX_TRIANGLES:
            raise ValueError("an array has a wrong shape")
        data = _read(child.stdout, 8 * math.prod(rows))
        arrays[key] = np.frombuffer(data, DTYPES[key]).reshape(rows).copy()
    return header, arrays


def _read(pipe: IO[bytes], size: int) -> bytes:
    data = pipe.read(size)
    if len(data) < size:
        raise OSError("the child has ended")
    return data


def mesh_from_answer(arrays: dict[str, NDArray[Any]], location: str) -> Mesh:
    """Returns the mesh in an answer: vertices (V, 3) [m] and faces (F, 3). Raises SceneError if they are not a mesh."""
    vertices, faces = arrays.get("vertices", np.zeros(0)), arrays.get("faces", np.zeros(0))
    if (
        vertices.ndim != 2 or faces.ndim != 2 or len(faces) == 0 or len(faces) > MAX_TRIANGLES
        or not (np.abs(vertices) <= 2 * MAX_COORDINATE).all() or faces.min() < 0 or faces.max() >= len(vertices)
    ):  # fmt: skip
        raise SceneError(f"{location}: the parser returned an invalid answer; export the file again")
    return Mesh(vertices, faces)
