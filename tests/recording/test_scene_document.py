"""The document of a scene, and its files' hashes."""

import hashlib
import json
from pathlib import Path

import pytest

import radar_service as rs
from radar_service.recording.scene_document import scene_document
from radar_service.stream.source import SceneOrder
from radar_service.truth.scene_hash import scene_hash
from tests.recording.scenes import MOVING


def test_the_document_gives_the_same_scene_again(tmp_path: Path) -> None:
    (path := tmp_path / "scene.json").write_text(json.dumps(MOVING))
    document, files = scene_document(SceneOrder(path))
    assert document is not None and files == {}
    assert scene_hash(rs.load_scene(json.loads(json.dumps(document)))) == scene_hash(rs.load_scene(MOVING))


def test_the_rate_of_rotation_is_that_of_the_order() -> None:
    document, _ = scene_document(SceneOrder(MOVING, rpm=12.5))
    assert document is not None and document["radar"]["rpm"] == 12.5 and document["radar"]["azimuths"] == 64


@pytest.mark.parametrize(("radar", "rpms"), [("pier", [24, 12.5]), (None, [12.5, 48])])
def test_of_several_radars_the_rate_is_that_of_the_one_that_is_named(radar: str | None, rpms: list[float]) -> None:
    tables = [MOVING["radar"] | {"id": "bow", "rpm": 24}, MOVING["radar"] | {"id": "pier", "rpm": 48}]
    document, _ = scene_document(SceneOrder(MOVING | {"radar": tables}, rpm=12.5, radar=radar))
    assert document is not None and [table["rpm"] for table in document["radar"]] == rpms


def test_files_have_hashes(tmp_path: Path) -> None:
    (tmp_path / "ship.stl").write_bytes(b"solid")
    bodies = [{"name": name, "mesh": file} for name, file in (("a", "ship.stl"), ("b", "gone.stl"), ("c", "ship.stl"))]
    (path := tmp_path / "scene.json").write_text(json.dumps({"name": "s", "body": bodies}))
    _, files = scene_document(SceneOrder(path))
    assert files == {"gone.stl": None, "ship.stl": hashlib.sha256(b"solid").hexdigest()}


def test_a_scene_whose_file_has_gone_has_no_document(tmp_path: Path) -> None:
    assert scene_document(SceneOrder(tmp_path / "gone.json")) == (None, {})
