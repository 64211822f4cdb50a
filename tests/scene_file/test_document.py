"""Scene files: formats, names of packaged scenes, bad and arbitrary content."""

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from radar_service.scene_file.load import load_scene
from radar_service.world.error import SceneError
from tests.scene_file.scene_sources import problems


@pytest.mark.parametrize(
    "name, content, message",
    [
        ("a.toml", b"name = ", "not valid TOML"),
        ("a.toml", b"name = 1\nname = 2\n", "not valid TOML"),
        ("a.toml", b"name = \xff", "byte 7 is not UTF-8"),
        ("a.json", b"{", "not valid JSON"),
        ("a.json", b"[]", "holds a list; a scene is a table"),
        ("a.json", b"", "not valid JSON"),
        ("a.json", b'{"name": "a", "name": "b"}', 'the key "name" occurs twice'),
        ("a.json", b'{"radar": {"rpm": NaN}}', "radar.rpm: nan is not allowed"),
        ("a.json", b'{"radar": {"azimuths": ' + b"9" * 5000 + b"}}", "not valid JSON"),
        ("a.json", b"[" * 200_000, "nested more than 1000 deep"),
        ("a.json", b'{"a":' * 900 + b"1" + b"}" * 900, "nested"),
        ("a.toml", b"a = " + b"[" * 200_000, "nested more than 1000 deep"),
        ("a.toml", b"a." * 5000 + b"a = 1", "a key has more than 200 parts"),
        ("a.toml", b"a." * 100 + b"a = 1", "nested more than 24 deep"),
        ("a.toml", b'name = "x"\n[[body]]\nmesh = "a\\ship.obj"',
         "a backslash begins an escape; write paths with forward slashes"),
        ("a.json", b'{"body": [{"mesh":\n"a\\ship.obj"}]}', "a backslash begins an escape; write paths with forward slashes"),
        ("a.toml", b"",
         "scene: it is empty; give it a name, a radar or a body, or load one of aids, coast, far-target, harbour,"),
        ("a.yaml", b"name: a", 'the ending ".yaml" is not known'),
        ("a.toml", b"#" * (10 * 2**20 + 1), "larger than 10485760 bytes"),
        ("a.toml", b"name = 1979-05-27", "name: 1979-05-27 is not allowed; text"),
    ],
)  # fmt: skip
def test_bad_scene_files(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    (tmp_path / name).write_bytes(content)
    assert message in problems(tmp_path / name)[0]


@pytest.mark.parametrize(
    "source", ["no-such-scene", "scenes/no-such.toml", "../harbour", "", ".", "a\0b", "x" * 5000, Path("nix.toml")]
)
def test_missing_scenes(source: str | Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(problems(source)) == 1


@pytest.mark.parametrize("source", ["", " "])
def test_no_name_is_an_error_with_a_remedy(source: str) -> None:
    (message,) = problems(source)
    assert message.startswith(
        'scene: "" names no scene; give a .toml or .json file, or one of aids, coast, far-target, harbour, '
    )


@pytest.mark.parametrize("source", [None, 5, [1], b"scene", {"a"}])
def test_other_types_are_no_scene(source: Any) -> None:
    assert "is not a scene; give the path" in problems(source)[0]


def test_folders_and_unreadable_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "is a folder" in problems(tmp_path)[0]
    (tmp_path / "a.toml").write_text("")

    def refuse(path: Path, mode: str) -> None:
        raise PermissionError(13, "Permission denied")  # as for a user who may not; the superuser may read everything

    monkeypatch.setattr(Path, "open", refuse)
    assert "cannot be read ([Errno 13] Permission denied)" in problems(tmp_path / "a.toml")[0]


def test_packaged_scenes_are_found_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "pond.toml").write_text('name = "pond"')
    monkeypatch.chdir(tmp_path / "..")
    monkeypatch.setattr("radar_service.scene_file.document.packaged_folder", lambda name: tmp_path / name)
    assert load_scene("pond").name == load_scene("scenes/pond.toml").name == load_scene("pond.toml").name == "pond"
    assert "packaged scenes are pond" in problems("ponds")[0]


@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(st.sampled_from(["a.toml", "a.json"]), st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
def test_arbitrary_files_raise_only_scene_errors(
    tmp_path_factory: pytest.TempPathFactory, name: str, content: bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(content)
    try:
        load_scene(path)
    except SceneError as fault:
        assert fault.problems


def test_one_line_of_many_numbers_is_no_long_key(tmp_path: Path) -> None:
    """300 decimals in one line of JSON or TOML are numbers; 300 dotted parts are a key too long."""
    rows = [[0.5 * k, -0.25 * k] for k in range(300)]
    scene = {"name": "table", "radar": {"pattern": rows, "range_max_m": 300.0}}
    (tmp_path / "a.json").write_text(json.dumps(scene))
    (tmp_path / "a.toml").write_text(f"[radar]\nrange_max_m = 300\npattern = [[0, 0],\n{str(rows[1:])[1:]}\n")
    for name in ("a.json", "a.toml"):
        assert len(load_scene(tmp_path / name).radar.pattern.rows) == 300
    (tmp_path / "b.toml").write_text(f"x = {{ {'.'.join('a' * 300)} = 1 }}\n")
    with pytest.raises(SceneError, match="a key has more than 200 parts"):
        load_scene(tmp_path / "b.toml")
