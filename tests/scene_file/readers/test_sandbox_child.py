"""The child process of the sandbox: its limits, and what it answers where a parser fails."""

import json
import os
import subprocess
import sys

import pytest

from radar_service.scene_file.readers.file_format import IN_PROCESS, BodyFile, LoadedBody
from radar_service.scene_file.readers.mesh import MeshFile
from radar_service.scene_file.readers.sandbox_child import answer
from tests.scene_file.readers.mesh_files import exported

FILE = MeshFile(exported("stl"), "a.stl", "here")

REACH_OUT = """
import json, os, socket, sys
from radar_service.processes import limits
kept = os.dup(1)
limits.limit_memory(2**30)
limits.forbid_access()
outcome = {}
for name, act in {
    "open": lambda: open("/etc/hostname"), "write": lambda: open("/tmp/radar-sandbox-test", "w"), "socket": socket.socket,
    "fork": lambda: os.fork() or os._exit(0) if os.getuid() else (_ for _ in ()).throw(OSError("root may")),
    "memory": lambda: bytearray(2**31),
}.items():
    try:
        act()
        outcome[name] = "done"
    except (OSError, MemoryError) as fault:
        outcome[name] = type(fault).__name__
os.write(kept, json.dumps(outcome).encode())
"""


def test_the_child_has_no_access() -> None:
    environment = {"PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
    out = subprocess.run([sys.executable, "-c", REACH_OUT], capture_output=True, env=environment, check=True, timeout=60)
    refused = json.loads(out.stdout)
    assert "done" not in refused.values() and refused["memory"] == "MemoryError", refused


class Failing:
    """A reader on which each file raises an error."""

    max_triangles = 1

    def __init__(self, error: Exception) -> None:
        self.error = error

    def read(self, file: BodyFile) -> tuple[LoadedBody, ...]:
        raise self.error


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (MemoryError(), "here: the file takes too much memory to read; make it smaller"),
        (KeyError("x"), "here: the file cannot be read (KeyError: 'x'); export it again"),
    ],
)
def test_an_error_of_a_parser_is_a_refusal_and_the_child_is_to_be_replaced(error: Exception, line: str) -> None:
    assert answer(FILE, Failing(error)) == ({"problems": [line], "bodies": [], "exhausted": True}, [])


def test_an_upload_may_have_so_many_triangles(monkeypatch: pytest.MonkeyPatch) -> None:
    header, (vertices, faces) = answer(FILE, IN_PROCESS)
    assert header["problems"] == [] and vertices.shape[1:] == (3,) and faces.shape == (12, 3)
    monkeypatch.setattr("radar_service.scene_file.readers.sandbox_child.MAX_TRIANGLES", 11)
    line = "here: the mesh has 12 triangles; an upload may have at most 11: simplify it"
    assert answer(FILE, IN_PROCESS) == ({"problems": [line], "bodies": []}, [])
