"""The sandbox: it returns what the parser in this process returns, and survives any file."""

import io
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from radar_service.processes.processor_time import BACKSTOP, MAX_PROCESSOR_TIME, MachineBusyError
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.readers.mesh_reader import IN_PROCESS
from radar_service.scene_file.readers.sandbox import Sandbox, mesh_from_answer
from radar_service.world.error import SceneError
from tests.scene_file.readers.mesh_files import chain, exported, glb_with, stl_claiming

CUBE = exported("stl")


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    limited = Sandbox()
    yield limited
    limited.close()


@pytest.mark.parametrize("ending", ["obj", "stl", "ply", "glb", "stl_ascii"])
def test_a_mesh_equals_that_read_in_process(sandbox: Sandbox, ending: str) -> None:
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
def test_a_height_map_equals_that_read_in_process(sandbox: Sandbox, name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    location = {"south_west_deg": [50.0, 1.0], "north_east_deg": [50.1, 1.2], "low_m": -50, "high_m": 500}
    scene = {"origin": {"latitude_deg": 50.05, "longitude_deg": 1.1},
             "body": [{"name": "coast", "heightmap": name, "position_m": [0, 0, 1], **location}]}  # fmt: skip
    there, here = (load_scene(scene, folder=tmp_path, mesh_reader=who) for who in (sandbox, IN_PROCESS))
    mesh, expected = there.bodies[0].mesh, here.bodies[0].mesh
    assert mesh is not None and expected is not None
    np.testing.assert_array_equal(mesh.vertices, expected.vertices)
    np.testing.assert_array_equal(mesh.faces, expected.faces)
    np.testing.assert_array_equal(there.bodies[0].motion.position, here.bodies[0].motion.position)
    assert (there.warnings, there.notes) == (here.warnings, here.notes)


HOSTILE = [
    ("a.obj", b""), ("a.obj", b"v 0 0 0\nf 1 2 99999999999999999999\n"), ("a.obj", b"v 0 0 nan\n" * 3 + b"f 1 2 3\n"),
    ("a.stl", stl_claiming(4_000_000_000)), ("a.stl", CUBE[:-20]), ("a.stl", b"\0" * 84), ("a.stl", b"PK\x03\x04" * 30),
    ("a.ply", exported("ply").replace(b"element vertex 8", b"element vertex 1000000000")),
    ("a.ply", exported("ply").replace(b"element face 12", b"element face 1000000000")), ("a.ply", exported("ply")[:-30]),
    ("a.glb", glb_with(chain)), ("a.glb", glb_with(lambda t: t["accessors"][0].update(count=2**30))),
    ("a.glb", glb_with(lambda t: t["accessors"][0].update(count=-3))),
    ("a.glb", glb_with(lambda t: t["accessors"][0].pop("bufferView"))),
    ("a.glb", glb_with(lambda t: t["buffers"][0].update(uri="../../etc/passwd"))),
    ("a.glb", glb_with(lambda t: t["buffers"][0].update(uri="file:///etc/passwd"))),
    ("a.glb", glb_with(lambda t: t["buffers"][0].update(uri="http://127.0.0.1:9/x.bin"))),
    ("a.glb", glb_with(lambda t: t["nodes"].extend([{}] * 100_001))),
    ("a.glb", b"glTF" + struct.pack("<II", 2, 20) + b"\xff\xff\xff\xffJSON"),
    ("a.zip", b"PK\x03\x04"), ("a.gltf", b"{}"), ("a.bz2", b"BZh9"), ("a", b"v"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content"), HOSTILE)
def test_a_hostile_file_is_refused_in_the_same_words(sandbox: Sandbox, name: str, content: bytes) -> None:
    message = []
    for who in (sandbox, IN_PROCESS):
        with pytest.raises(SceneError) as caught:
            who.mesh(content, name, "body[0].mesh: a", 1.0, "z")
        message.append(caught.value.problems)
    assert message[0] == message[1] and message[0][0].startswith("body[0].mesh: a")


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
from radar_service.scene_file.readers import sandbox_child
class Spinning:
    def mesh(self, *arguments):
        while True:
            pass
sandbox_child.limit_process(2**30)
sandbox_child.serve(sys.stdin.buffer, sys.stdout.buffer, 0.2, Spinning())
"""


def test_a_parser_that_never_ends_is_ended_by_its_own_limit_of_processor_time() -> None:
    limited = Sandbox(processor_time=0.2, command=[sys.executable, "-c", SPIN])
    try:
        with pytest.raises(
            SceneError, match="^here: the file takes more than 0.2 s of processor time to read; make it smaller"
        ):
            limited.mesh(CUBE, "a.stl", "here", 1.0, "z")
    finally:
        limited.close()


@pytest.mark.parametrize(
    "program",
    ["import sys; sys.stdin.buffer.read()", "import time; time.sleep(1e4)"],
    ids=["while it reads", "while it starts"],
)
def test_a_machine_that_gives_the_child_no_time_is_no_fault_of_the_file(program: str) -> None:
    limited = Sandbox(backstop=0.05, command=[sys.executable, "-c", program])
    try:
        with pytest.raises(MachineBusyError, match="^here: the machine is busy: .* in 0.05 s; try again later$"):
            limited.mesh(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a.obj", "here", 1.0, "z")
    finally:
        limited.close()


def test_the_documents_have_the_figures_of_the_code() -> None:
    for name in ("promises", "rest"):
        text = (Path(__file__).parents[3] / "docs" / f"{name}.md").read_text()
        assert f"{MAX_PROCESSOR_TIME:g} s of processor time" in text and f"{BACKSTOP:g} s" in text, name


@pytest.mark.parametrize(
    "answer",
    [
        b"", b"\xff" * 16, struct.pack("<Q", 2) + b"{}", struct.pack("<Q", 2) + b"[]", struct.pack("<Q", 9) + b"not json!",
    ],
)  # fmt: skip
def test_an_invalid_answer_of_the_child_is_a_refusal(answer: bytes) -> None:
    program = f"import sys; sys.stdin.buffer.read(8); sys.stdout.buffer.write({answer!r})"
    limited = Sandbox(command=[sys.executable, "-c", program])
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
    with pytest.raises(SceneError, match="the parser returned an invalid answer"):
        mesh_from_answer(arrays, "here")
