"""The limited process: it builds what this one builds, and whatever is fed to it, this one goes on untouched."""

import io
import json
import os
import resource
import signal
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from radar_service.scene import sandbox as sandbox_module
from radar_service.scene import sandbox_child
from radar_service.scene.error import SceneError
from radar_service.scene.load import IN_PROCESS, load_scene
from radar_service.scene.sandbox import Sandbox
from tests.scene.test_mesh import chain, exported, glb_with, stl_claiming

CUBE = exported("stl")


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    limited = Sandbox()
    yield limited
    limited.close()


glb = glb_with


@pytest.mark.parametrize("ending", ["obj", "stl", "ply", "glb", "stl_ascii"])
def test_a_mesh_is_the_one_built_here(sandbox: Sandbox, ending: str) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2).export(file_type=ending)
    content = ball if isinstance(ball, bytes) else ball.encode()
    name = f"ball.{ending.removesuffix('_ascii')}"
    there, here = (who.mesh(content, name, "place", 2.0, "y") for who in (sandbox, IN_PROCESS))
    np.testing.assert_array_equal(there.mesh.vertices, here.mesh.vertices)
    np.testing.assert_array_equal(there.mesh.faces, here.mesh.faces)
    assert there.findings == here.findings and len(here.mesh.faces) == 320


def picture(kind: str, **options: Any) -> bytes:
    file = io.BytesIO()
    slope = np.add.outer(np.arange(200), np.arange(150)) * 100
    Image.fromarray(slope.astype(np.uint16)).save(file, kind, **options)
    return file.getvalue()


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("h.png", picture("PNG")), ("h.tif", picture("TIFF")), ("h.tiff", picture("TIFF", compression="tiff_lzw")),
        ("h.tif", picture("TIFF", compression="tiff_adobe_deflate")), ("h.tif", picture("TIFF", compression="packbits")),
    ],
)  # fmt: skip
def test_a_height_map_is_the_one_built_here(sandbox: Sandbox, name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    place = {"south_west_deg": [50.0, 1.0], "north_east_deg": [50.1, 1.2], "low_m": -50, "high_m": 500}
    scene = {"origin": {"latitude_deg": 50.05, "longitude_deg": 1.1},
             "body": [{"name": "coast", "heightmap": name, "position_m": [0, 0, 1], **place}]}  # fmt: skip
    there, here = (load_scene(scene, folder=tmp_path, builder=who) for who in (sandbox, IN_PROCESS))
    mesh, wanted = there.bodies[0].mesh, here.bodies[0].mesh
    assert mesh is not None and wanted is not None
    np.testing.assert_array_equal(mesh.vertices, wanted.vertices)
    np.testing.assert_array_equal(mesh.faces, wanted.faces)
    np.testing.assert_array_equal(there.bodies[0].motion.position, here.bodies[0].motion.position)
    assert there.warnings == here.warnings


HOSTILE = [
    ("a.obj", b""), ("a.obj", b"v 0 0 0\nf 1 2 99999999999999999999\n"), ("a.obj", b"v 0 0 nan\n" * 3 + b"f 1 2 3\n"),
    ("a.stl", stl_claiming(4_000_000_000)), ("a.stl", CUBE[:-20]), ("a.stl", b"\0" * 84), ("a.stl", b"PK\x03\x04" * 30),
    ("a.ply", exported("ply").replace(b"element vertex 8", b"element vertex 1000000000")),
    ("a.ply", exported("ply").replace(b"element face 12", b"element face 1000000000")), ("a.ply", exported("ply")[:-30]),
    ("a.glb", glb(chain)), ("a.glb", glb(lambda t: t["accessors"][0].update(count=2**30))),
    ("a.glb", glb(lambda t: t["accessors"][0].update(count=-3))),
    ("a.glb", glb(lambda t: t["accessors"][0].pop("bufferView"))),
    ("a.glb", glb(lambda t: t["buffers"][0].update(uri="../../etc/passwd"))),
    ("a.glb", glb(lambda t: t["buffers"][0].update(uri="file:///etc/passwd"))),
    ("a.glb", glb(lambda t: t["buffers"][0].update(uri="http://127.0.0.1:9/x.bin"))),
    ("a.glb", glb(lambda t: t["nodes"].extend([{}] * 100_001))),
    ("a.glb", b"glTF" + struct.pack("<II", 2, 20) + b"\xff\xff\xff\xffJSON"),
    ("a.zip", b"PK\x03\x04"), ("a.gltf", b"{}"), ("a.bz2", b"BZh9"), ("a", b"v"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content"), HOSTILE)
def test_a_hostile_file_is_refused_in_the_same_words(sandbox: Sandbox, name: str, content: bytes) -> None:
    said = []
    for who in (sandbox, IN_PROCESS):
        with pytest.raises(SceneError) as caught:
            who.mesh(content, name, "body[0].mesh: a", 1.0, "z")
        said.append(caught.value.problems)
    assert said[0] == said[1] and said[0][0].startswith("body[0].mesh: a")


def test_more_memory_than_allowed_is_refused_and_the_next_file_is_read() -> None:
    """400 000 triangles of STL are 20 MB; their coordinates alone, as float64, are 29 MB, and several copies are needed."""
    limited = Sandbox(memory=96 * 2**20)
    try:
        with pytest.raises(SceneError, match="^here: .*(MiB|too much memory)"):
            limited.mesh(np.random.default_rng(1).bytes(80) + struct.pack("<I", 400_000) + b"\1" * 20_000_000, "a.stl",
                         "here", 1.0, "z")  # fmt: skip
        assert len(limited.mesh(CUBE, "a.stl", "here", 1.0, "z").mesh.faces) == 12
    finally:
        limited.close()


SPIN = """
import sys
from radar_service.scene import sandbox_child as child
def spin(*_):
    while True:
        pass
child.BUILD.mesh = spin
child.limit(2**30)
child.serve(sys.stdin.buffer, sys.stdout.buffer, 0.2)
"""


@pytest.mark.parametrize(("patience", "ended_by"), [(0.05, signal.SIGKILL), (30.0, signal.SIGXCPU)])
def test_a_parser_that_never_ends_is_ended(patience: float, ended_by: signal.Signals) -> None:
    """By the parent's patience, and by the child's own limit of processor time."""
    children = []

    class Spinning(Sandbox):
        def _begin(self) -> "subprocess.Popen[bytes]":
            environment = {"PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
            command = [sys.executable, "-c", SPIN]
            children.append(
                subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
            )  # fmt: skip
            return children[-1]

    limited = Spinning(processor=0.2, patience=patience)
    try:
        with pytest.raises(SceneError, match="here: reading it takes more than 0.2 s of computing"):
            limited.mesh(CUBE, "a.stl", "here", 1.0, "z")
        assert children[0].returncode == -ended_by
    finally:
        limited.close()


REACH_OUT = """
import json, os, socket, sys
from radar_service.scene import sandbox_child as child
child.warm_up()
kept = os.dup(1)
child.limit(2**30)
said = {}
for name, act in {
    "open": lambda: open("/etc/hostname"), "write": lambda: open("/tmp/radar-sandbox-test", "w"), "socket": socket.socket,
    "fork": lambda: os.fork() or os._exit(0) if os.getuid() else (_ for _ in ()).throw(OSError("root may")),
    "memory": lambda: bytearray(2**31),
}.items():
    try:
        act()
        said[name] = "done"
    except (OSError, MemoryError) as fault:
        said[name] = type(fault).__name__
os.write(kept, json.dumps(said).encode())
"""


def test_the_child_reaches_nothing() -> None:
    environment = {"PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
    out = subprocess.run([sys.executable, "-c", REACH_OUT], capture_output=True, env=environment, check=True, timeout=60)
    refused = json.loads(out.stdout)
    assert "done" not in refused.values() and refused["memory"] == "MemoryError", refused


@pytest.mark.parametrize(
    "answer",
    [
        b"", b"\xff" * 16, struct.pack("<Q", 2) + b"{}", struct.pack("<Q", 2) + b"[]", struct.pack("<Q", 9) + b"not json!",
    ],
)  # fmt: skip
def test_nonsense_from_the_child_is_a_refusal(answer: bytes) -> None:
    class Babbling(Sandbox):
        def _begin(self) -> "subprocess.Popen[bytes]":
            command = [sys.executable, "-c", f"import sys; sys.stdin.buffer.read(8); sys.stdout.buffer.write({answer!r})"]
            return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    limited = Babbling()
    try:
        with pytest.raises(SceneError, match="^here: "):
            limited.mesh(CUBE, "a.stl", "here", 1.0, "z")
    finally:
        limited.close()


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [
        ([[0, 0, 0], [1, 0, 0]], [[0, 1, 2]]), ([[0, 0, 0]], [[0, 0, -1]]), ([[0, 0, float("nan")]], [[0, 0, 0]]),
        ([[0, 0, 1e9]], [[0, 0, 0]]), ([[0, 0, 0]], []),
    ],
)  # fmt: skip
def test_arrays_that_are_no_mesh_are_a_refusal(vertices: list[Any], faces: list[Any]) -> None:
    arrays = {"vertices": np.array(vertices, float), "faces": np.array(faces, np.int64).reshape(-1, 3)}
    with pytest.raises(SceneError, match="nonsense"):
        sandbox_module._mesh(arrays, "here")


def test_the_processor_limit_is_for_each_file() -> None:
    before = resource.getrlimit(resource.RLIMIT_CPU)
    try:
        sandbox_child.limit_processor(5.0)
        used = resource.getrusage(resource.RUSAGE_SELF)
        soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
        assert hard == before[1] and 5.0 <= soft - used.ru_utime - used.ru_stime <= 6.1
    finally:
        resource.setrlimit(resource.RLIMIT_CPU, before)
