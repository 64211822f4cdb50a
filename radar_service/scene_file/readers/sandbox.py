"""Parses untrusted files in a child process that has limited resources and no access to files or the network.

The child (sandbox_child) limits itself before its first file: memory, processor time, no new file, socket or process. Each answer
is checked, as a parser may be compromised. A child that ends, stalls or reaches a limit is replaced.
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
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import MAX_COORDINATE
from radar_service.processes.limits import BACKSTOP, MAX_PROCESSOR_TIME, child_environment, machine_busy
from radar_service.scene_file.readers.file_format import BodyFile, LoadedBody
from radar_service.world import Mesh, SceneError

MAX_MEMORY = 2 * 2**30  # bytes above the interpreter's own; an STL of 64 MiB needs 1.2 GiB
MAX_TRIANGLES = 4_000_000  # of a scene: some 300 MB with their ray-tracing tree
MAX_HEADER_BYTES = 2**20  # of an answer
CPU_TIME_STATUS = -24  # exit status of a process that SIGXCPU ended
CHILD = "radar_service.scene_file.readers.sandbox_child"
MAX_PROBLEMS, MAX_PROBLEM = 20, 2000  # of an answer, characters of each
MAX_FINDINGS, MAX_FINDING, MAX_NAME = 20, 500, 200  # of a body, characters of each
ANSWER_ERRORS = (  # that an answer of another form may raise, or none
    OSError, ValueError, LookupError, TypeError, AttributeError, struct.error, OverflowError, RecursionError,
)  # fmt: skip
DTYPES = {"vertices": "<f8", "faces": "<i8", "position": "<f8"}  # of arrays by their names
SIDES: dict[str, list[int]] = {"vertices": [3], "faces": [3], "position": []}  # of their rows


class Answer(NamedTuple):
    """What the child says of a file: problems as lines of a refusal, bodies, and whether it is to be replaced."""

    problems: tuple[str, ...]
    bodies: tuple[LoadedBody, ...]
    exhausted: bool


class Sandbox:
    """A MeshReader that reads files in a child process, one at a time. Call `close` after use.

    memory: limit of the child [bytes above the interpreter's own]. processor_time: limit of its parsing [s per file]. backstop:
    wall-clock time after which the parent ends the child, its start included [s per file]. command: the program that answers, by
    default sandbox_child. The child starts with the first file, or earlier by `start`.
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

    def read(self, file: BodyFile) -> tuple[LoadedBody, ...]:
        """Returns the bodies in a file, as an InProcessReader.

        Raises SceneError also at the limits of the child and for an invalid answer, and MachineBusyError at the backstop.
        """
        answer = self._answer(file)
        if answer.problems:
            raise SceneError(*answer.problems)
        if not is_valid(answer.bodies, file):
            raise SceneError(f"{file.location}: the parser returned an invalid answer; export the file again")
        return answer.bodies

    def _answer(self, file: BodyFile) -> "Answer":
        with self._lock:
            child, timed_out = self._running_child(), threading.Event()

            def end_child() -> None:
                timed_out.set()
                child.kill()

            timer = threading.Timer(self._backstop, end_child)
            timer.start()
            try:
                answer = _exchange(child, pickle.dumps(file))
            except ANSWER_ERRORS:
                self._end()
                if timed_out.is_set():
                    raise machine_busy(file.location, self._backstop) from None
                reason = self._reason(child.returncode)
                raise SceneError(f"{file.location}: {reason}; make it smaller or export it again") from None
            finally:
                timer.cancel()
            if answer.exhausted:
                self._end()
                self._running_child()
        return answer

    def _running_child(self) -> subprocess.Popen[bytes]:
        """Returns the child; starts one if none is running."""
        if self._child is None or self._child.poll() is not None:
            inherited = {key: os.environ[key] for key in ("SYSTEMROOT",) if key in os.environ}  # Windows needs it
            environment, pipe = inherited | child_environment(), subprocess.PIPE
            self._child = subprocess.Popen(
                self._command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, env=environment
            )  # fmt: skip
        return self._child

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


def _exchange(child: subprocess.Popen[bytes], request: bytes) -> Answer:
    """Sends a request, returns the answer. Raises errors of many types if the child ends or its answer has another form."""
    assert child.stdin is not None and child.stdout is not None
    child.stdin.write(struct.pack("<Q", len(request)) + request)
    child.stdin.flush()
    (size,) = struct.unpack("<Q", _read(child.stdout, 8))
    if size > MAX_HEADER_BYTES:
        raise ValueError("the answer is too long")
    header = json.loads(_read(child.stdout, size))
    room = dict.fromkeys(DTYPES, 3 * MAX_TRIANGLES)  # rows that arrays of each name may still have
    bodies = tuple(_body(described, child.stdout, room) for described in header["bodies"])
    problems = tuple(str(line)[:MAX_PROBLEM] for line in header["problems"][:MAX_PROBLEMS])
    return Answer(problems, bodies, bool(header.get("exhausted")))


def _body(described: dict[str, Any], pipe: IO[bytes], room: dict[str, int]) -> LoadedBody:
    """Returns a body with its arrays from the pipe, which may hold anything of the right shape; takes their rows from `room`."""
    arrays = {}
    for key, shape in described["arrays"].items():
        rows = [int(side) for side in shape]
        if rows[1:] != SIDES[key] or not 0 <= rows[0] <= room[key]:
            raise ValueError("an array has a wrong shape")
        room[key] -= rows[0]
        data = _read(pipe, 8 * math.prod(rows))
        arrays[key] = np.frombuffer(data, DTYPES[key]).reshape(rows).copy()
    findings = tuple(str(line)[:MAX_FINDING] for line in described["findings"][:MAX_FINDINGS])
    mesh = Mesh(arrays["vertices"], arrays["faces"])
    return LoadedBody(mesh, findings, arrays.get("position"), str(described["name"])[:MAX_NAME])


def _read(pipe: IO[bytes], size: int) -> bytes:
    data = pipe.read(size)
    if len(data) < size:
        raise OSError("the child has ended")
    return data


def is_valid(bodies: Sequence[LoadedBody], file: BodyFile) -> bool:
    """Whether bodies may be those of a file: their number, their triangles, finite numbers, a position where it must have one."""
    if not 1 <= len(bodies) <= file.max_bodies or sum(len(body.mesh.faces) for body in bodies) > MAX_TRIANGLES:
        return False
    return all(_is_mesh(body.mesh) and _is_position(body.position, file.placed) for body in bodies)


def _is_mesh(mesh: Mesh) -> bool:
    vertices, faces = mesh.vertices, mesh.faces
    return len(faces) > 0 and bool(
        (np.abs(vertices) <= 2 * MAX_COORDINATE).all() and faces.min() >= 0 and faces.max() < len(vertices)
    )


def _is_position(position: NDArray[Any] | None, placed: bool) -> bool:
    if position is None:
        return not placed
    return position.shape == (3,) and bool((np.abs(position) <= 2 * MAX_COORDINATE).all())
