"""The table of mesh formats: which one a file has, and what is refused because of its name or content."""

from dataclasses import replace

import pytest

from radar_service.scene_file.readers.file_format import Format, Triangles
from radar_service.scene_file.readers.formats import detected_format, format_of, own_formats
from tests.plug_ins import join
from tests.scene_file.readers.mesh_files import exported, refused


@pytest.mark.parametrize("kind", own_formats(), ids=lambda kind: kind.name)
def test_each_format_recognises_its_examples_and_reads_them(kind: Format[Triangles]) -> None:
    for content in kind.examples():
        assert detected_format(content) is kind
        assert format_of(content, f"A.{kind.name[:3].upper()}", "m") is kind
        vertices, faces = kind.parse(content, "m")
        assert vertices.shape[1:] == faces.shape[1:] == (3,) and 0 <= faces.min() < faces.max() < len(vertices)


def test_a_check_comes_before_the_parser_and_errors_of_a_parser_are_refusals(monkeypatch: pytest.MonkeyPatch) -> None:
    def parse(content: bytes, location: str) -> Triangles:
        return [][len(content)]

    def check(content: bytes, location: str) -> None:
        checked.append(location)

    checked: list[str] = []
    kind = Format[Triangles]("one", lambda content: content.startswith(b"one"), parse, lambda: (), check)
    join(monkeypatch, "readers", "one", kind)
    assert "is not readable as ONE (IndexError: list index out of range); export it again" in refused(b"one", "a.one")
    assert checked == ["body[0].mesh: a"]
    join(monkeypatch, "readers", "one", (replace(kind, check=parse),))
    assert "is not readable as ONE (IndexError" in refused(b"one", "a.one") and len(checked) == 1


@pytest.mark.parametrize(
    "content, words",
    [
        (b"\x89PNG\r\n\x1a\n", "PNG"), (b"PK\x03\x04", "ZIP"), (b"%PDF\nv 1 2 3\n", "PDF"), (b"\0\1", "binary data"),
        (b" {}", "JSON or XML"), (b"<a>\nv 1 2 3\n", "JSON or XML"), (b"vertex 1", "text of another kind"),
        (exported("ply"), "ply"), (exported("stl_ascii"), "stl_ascii"),
        (b"ply\nv 1 2 3\n", "ply"), (b"solid with a facet".ljust(80) + exported("stl")[80:], "stl"),
    ],
)  # fmt: skip
def test_content_that_is_not_what_the_ending_says_is_named(content: bytes, words: str) -> None:
    assert refused(content, "a.obj") == (
        f"body[0].mesh: a: the file is not OBJ as its ending says; it looks like {words}: rename it or export it again"
    )


@pytest.mark.parametrize(
    "name, content, message",
    [
        ("a.gltf", b"{}", ".gltf is not read; it keeps its data in other files: export it as .glb, which holds all"),
        ("a.zip", b"PK\x03\x04", ".zip is not read; it packs other files: unpack it"),
        ("my boat.x", b"xof 0303",
         ".x is not read; no reader of it is built in: assimp export 'my boat.x' 'my boat.obj' -tri"),
        ("b.3DS", b"MM", ".3ds is not read; no reader of it is built in: assimp export b.3DS b.obj -tri makes an .obj of it"),
        ("b.dae", b"<COLLADA/>", "assimp export b.dae b.obj -tri"),
        ("a.exe", b"MZ", 'the ending ".exe"'),
        ("noending", b"v 0 0 0", 'the ending ""'),
    ],
)  # fmt: skip
def test_names_without_a_format(name: str, content: bytes, message: str) -> None:
    assert message in refused(content, name)


def test_the_endings_are_named() -> None:
    assert "is not one of .glb, .obj, .ply, .stl; " in refused(b"x", "a.exe")
