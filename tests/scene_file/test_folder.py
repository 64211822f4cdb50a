"""Files of a scene stay inside its folder."""

from pathlib import Path

import pytest

from radar_service.scene_file.load import load_scene
from tests.scene_file.scene_sources import TETRAHEDRON, point, problems


@pytest.mark.parametrize(
    "name, message",
    [
        ("missing.obj", '"missing.obj" is not a file in'),
        ("../outside.obj", "leaves the scene's folder"),
        ("/etc/passwd", "leaves the scene's folder"),
        ("sub/../../outside.obj", "leaves the scene's folder"),
        ("link.obj", "is a link out of"),
        ("linked/outside.obj", "is a link out of"),
        ("sub", "is a folder"),
        (
            "C:\\ferry.obj",
            '"C:\\\\ferry.obj" has a backslash, or what an escape makes of one; write paths with forward slashes',
        ),
        ("meshes\ferry.obj", '"meshes\\x0cerry.obj" has a backslash, or what an escape makes of one; write'),
        ("file:ferry.obj", "leaves the scene's folder"),
        ("a\0b.obj", "cannot be looked up"),
        ("x" * 400, "cannot be looked up"),
        ("loop.obj", "cannot be looked up"),
    ],
)
def test_files_stay_in_the_folder(folder: Path, name: str, message: str) -> None:
    (folder.parent / "outside.obj").write_text(TETRAHEDRON)
    (folder / "sub").mkdir()
    (folder / "link.obj").symlink_to(folder.parent / "outside.obj")
    (folder / "linked").symlink_to(folder.parent)
    (folder / "loop.obj").symlink_to(folder / "loop.obj")
    (result,) = problems({"body": [{"name": "a", "mesh": name}]}, folder=folder)
    assert result.startswith("body[0].mesh: ") and message in result
    (result,) = problems({"body": [{"name": "a", "heightmap": name}]}, folder=folder)
    assert result.startswith("body[0].heightmap: ") and message in result
    (result,) = problems({"body": [point(track=name)]}, folder=folder)
    assert result.startswith("body[0].track: ") and message in result


def test_links_and_folders_inside_the_folder_are_fine(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "other.obj").symlink_to(folder / "ferry.obj")
    scene = load_scene({"body": [{"name": "a", "mesh": "sub/other.obj"}]}, folder=folder)
    assert scene.bodies[0].mesh is not None
