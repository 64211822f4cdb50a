"""The sandbox: it returns what the parser in this process returns, and survives any file."""

import io
import json
import pickle
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from radar_service.processes.limits import BACKSTOP, MAX_PROCESSOR_TIME, MachineBusyError
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.readers.file_format import IN_PROCESS, BodyFile, Format, LoadedBody, Triangles
from radar_service.scene_file.readers.formats import own_formats
from radar_service.scene_file.readers.heightmap import HeightMapFile
from radar_service.scene_file.readers.mesh import MAX_BODIES, MeshFile
from radar_service.scene_file.readers.sandbox import MAX_TRIANGLES, Sandbox, is_valid
from radar_service.world.body import Mesh
from radar_service.world.error import SceneError
from tests.scene_file.readers.mesh_files import chain, exported, glb_with, stl_claiming

CUBE = exported("stl")


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    limited = Sandbox()
    yield limited
    limited.close()


@pytest.mark.parametrize("kind", own_formats(), ids=lambda kind: kind.name)
def test_a_mesh_equals_that_read_in_process(sandbox: Sandbox, kind: Format[Triangles]) -> None:
    for content in kind.examples():
        file = MeshFile(content, f"box.{kind.name[:3]}", "place", 2.0, "y")
        ((there,), (here,)) = (reader.read(file) for reader in (sandbox, IN_PROCESS))
        np.testing.assert_array_equal(there.mesh.vertices, here.mesh.vertices)
        np.testing.assert_array_equal(there.mesh.faces, here.mesh.faces)
        assert there[1:] == here[1:] and len(here.mesh.faces) > 0


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
    there, here = (load_scene(scene, folder=tmp_path, mesh_reader=reader) for reader in (sandbox, IN_PROCESS))
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
    for reader in (sandbox, IN_PROCESS):
        with pytest.raises(SceneError) as caught:
            reader.read(MeshFile(content, name, "body[0].mesh: a"))
        message.append(caught.value.problems)
    assert message[0] == message[1] and message[0][0].startswith("body[0].mesh: a")


def test_more_memory_than_allowed_is_refused_and_the_next_file_is_read() -> None:
    """400 000 triangles of STL are 20 MB; their coordinates alone, as float64, are 29 MB, and several copies are needed."""
    limited = Sandbox(memory=96 * 2**20)
    try:
        with pytest.raises(SceneError, match="^here: .*(MiB|too much memory)"):
            large = np.random.default_rng(1).bytes(80) + struct.pack("<I", 400_000) + b"\1" * 20_000_000
            limited.read(MeshFile(large, "a.stl", "here"))
        (cube,) = limited.read(MeshFile(CUBE, "a.stl", "here"))
        assert len(cube.mesh.faces) == 12
    finally:
        limited.close()


SPIN = """
import sys
from radar_service.processes.limits import limit_memory
from radar_service.scene_file.readers import sandbox_child
class Spinning:
    def read(self, file):
        while True:
            pass
limit_memory(2**30)
sandbox_child.serve(sys.stdin.buffer, sys.stdout.buffer, 0.2, Spinning())
"""


def test_a_parser_that_never_ends_is_ended_by_its_own_limit_of_processor_time() -> None:
    limited = Sandbox(processor_time=0.2, command=[sys.executable, "-c", SPIN])
    try:
        with pytest.raises(
            SceneError, match="^here: the file takes more than 0.2 s of processor time to read; make it smaller"
        ):
            limited.read(MeshFile(CUBE, "a.stl", "here"))
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
            limited.read(MeshFile(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a.obj", "here"))
    finally:
        limited.close()


def test_the_documents_have_the_figures_of_the_code() -> None:
    for name in ("accuracy", "rest"):
        text = (Path(__file__).parents[3] / "docs" / f"{name}.md").read_text()
        assert f"{MAX_PROCESSOR_TIME:g} s of processor time" in text and f"{BACKSTOP:g} s" in text, name


def answered(header: str, arrays: bytes = b"") -> bytes:
    return struct.pack("<Q", len(header)) + header.encode() + arrays


def described(**arrays: list[Any]) -> str:
    body = {"name": "", "findings": [], "arrays": {"vertices": [3, 3], "faces": [1, 3]} | arrays}
    return json.dumps({"problems": [], "bodies": [body]})


POINTS, CORNERS = np.eye(3).tobytes(), np.arange(3).tobytes()
INVALID = "here: the parser returned an invalid answer; export the file again"


def result(answer: bytes) -> str:
    """What the parent says of an answer: the number of triangles, or the refusal."""
    program = f"import sys; sys.stdin.buffer.read(8); sys.stdout.buffer.write({answer!r})"
    limited = Sandbox(command=[sys.executable, "-c", program])
    try:
        (body,) = limited.read(MeshFile(CUBE, "a.stl", "here"))
        return f"{len(body.mesh.faces)} triangles"
    except SceneError as refusal:
        return str(refusal)
    finally:
        limited.close()


ZEROS = bytes(1000)  # more than any of these answers declares, but for the one of 10^9 rows


@pytest.mark.parametrize(
    "answer",
    [
        b"", b"\xff" * 16, answered("{}"), answered("[]"), answered("not json!"), answered("[" * 100_000),
        answered('{"problems": [], "bodies": [5]}'), answered('{"bodies": []}'), answered(described(vertices=[3]), ZEROS),
        answered(described(vertices=[3, 3, 3]), ZEROS), answered(described(faces=[1, 2]), ZEROS),
        answered(described(faces=[-1, 3]), ZEROS), answered(described(vertices=[10**9, 3]), ZEROS),
        answered(described(vertices=[float("inf"), 3]), ZEROS), answered(described(other=[1, 3]), ZEROS),
        answered(described(), POINTS), pickle.dumps(answered(described(), POINTS + CORNERS)),
    ],
)  # fmt: skip
def test_an_answer_of_another_form_is_a_refusal(answer: bytes) -> None:
    assert result(answer).startswith("here: the file takes more than ")


def test_an_answer_is_taken_as_far_as_it_may_be_true() -> None:
    assert result(answered(described(), POINTS + CORNERS)) == "1 triangles"
    far = np.full(3, 1e9).tobytes()
    assert result(answered(described(position=[3]), POINTS + CORNERS + far)) == INVALID
    assert result(answered('{"problems": [], "bodies": []}')) == INVALID
    assert result(answered(json.dumps({"problems": ["x" * 2100] * 25, "bodies": []}))) == "\n".join(["x" * 2000] * 20)


def test_the_arrays_of_all_bodies_together_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three vertices for each of the triangles that a scene may have, here one; two bodies have six."""
    monkeypatch.setattr("radar_service.scene_file.readers.sandbox.MAX_TRIANGLES", 1)
    assert result(answered(described(), POINTS + CORNERS)) == "1 triangles"
    assert result(answered(described(vertices=[4, 3]), ZEROS)).startswith("here: the file takes more than ")
    two = json.loads(described())
    assert result(answered(json.dumps(two | {"bodies": two["bodies"] * 2}), ZEROS)).startswith("here: the file takes more")


TELLING = """
import json, os, struct, sys
while size := sys.stdin.buffer.read(8):
    sys.stdin.buffer.read(struct.unpack("<Q", size)[0])
    text = json.dumps({"problems": [str(os.getpid())], "bodies": [], "exhausted": EXHAUSTED}).encode()
    sys.stdout.buffer.write(struct.pack("<Q", len(text)) + text)
    sys.stdout.buffer.flush()
"""


@pytest.mark.parametrize("exhausted", [False, True])
def test_a_child_that_is_exhausted_is_replaced(exhausted: bool) -> None:
    limited = Sandbox(command=[sys.executable, "-c", TELLING.replace("EXHAUSTED", str(exhausted))])
    told = []
    try:
        for _ in range(2):
            with pytest.raises(SceneError) as refusal:
                limited.read(FILE)
            told.append(str(refusal.value))
    finally:
        limited.close()
    assert (told[0] != told[1]) is exhausted


MAP = HeightMapFile.examples()[0]
FILE = MeshFile(CUBE, "a.stl", "here")
HERE = np.zeros(3)


def triangle(vertices: Any = ((0, 0, 0), (1, 0, 0), (0, 1, 0)), faces: Any = ((0, 1, 2),)) -> Mesh:
    return Mesh(np.array(vertices, float).reshape(-1, 3), np.array(faces, np.int64).reshape(-1, 3))


@pytest.mark.parametrize(
    ("mesh", "position", "file"),
    [
        (triangle([[0, 0, 0], [1, 0, 0]]), None, FILE), (triangle([[0, 0, 0]], [[0, 0, -1]]), None, FILE),
        (triangle([[0, 0, float("nan")]], [[0, 0, 0]]), None, FILE), (triangle([[0, 0, 1e9]], [[0, 0, 0]]), None, FILE),
        (triangle(faces=[]), None, FILE), (triangle([], [[0, 0, 0]]), None, FILE), (triangle(), np.full(3, 1e9), FILE),
        (triangle(), None, MAP), (triangle(), np.full(3, np.nan), MAP), (triangle(), np.full(3, 1e9), MAP),
        (triangle(), np.zeros(4), MAP), (triangle(faces=np.zeros((MAX_TRIANGLES + 1, 3))), None, FILE),
    ],
)  # fmt: skip
def test_bodies_that_a_file_cannot_hold_are_not_valid(mesh: Mesh, position: Any, file: BodyFile) -> None:
    assert is_valid([LoadedBody(triangle(), (), HERE if file.placed else None)], file)
    assert not is_valid([LoadedBody(mesh, (), position)], file)


def test_a_file_holds_as_many_bodies_as_it_may() -> None:
    body = LoadedBody(triangle(), ())
    assert is_valid([body] * MAX_BODIES, FILE) and not is_valid([], FILE) and not is_valid([body] * (MAX_BODIES + 1), FILE)
