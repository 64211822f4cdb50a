"""Real meshes: open, doubled, of a thousand groups. They load, with a note that says what was result."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.scene_file.load import load_scene


def counted(path: Path) -> tuple[int, list[float], list[float]]:
    """Faces, and the corners of the box round all vertices, of an OBJ file of triangles; read without the loader."""
    lines = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([[float(word) for word in line[1:4]] for line in lines if line[:1] == ["v"]])
    used = {int(word.split("/")[0]) - 1 for line in lines if line[:1] == ["f"] for word in line[1:]}
    vertices = vertices[sorted(used)]
    return sum(line[:1] == ["f"] for line in lines), vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()


def test_every_building_tile(real_folder: Path) -> None:
    folder = real_folder / "swinomish"
    tiles = sorted(folder.glob("*.obj"))
    assert len(tiles) == 19
    bodies = [{"name": tile.stem, "mesh": tile.name, "up": "y", "material": "building"} for tile in tiles]
    scene = load_scene({"body": bodies}, folder=folder)
    for tile, body in zip(tiles, scene.bodies, strict=True):
        faces, low, high = counted(tile)
        assert body.mesh is not None and len(body.mesh.faces) <= faces
        assert len(body.mesh.faces) > 0.99 * faces  # what is dropped has no area or stands there twice
        np.testing.assert_allclose(body.mesh.vertices.min(axis=0), [low[0], -high[2], low[1]], atol=1e-9)
        np.testing.assert_allclose(body.mesh.vertices.max(axis=0), [high[0], -low[2], high[1]], atol=1e-9)
    assert not scene.warnings and scene.notes[-1] == "19 meshes are not watertight: body[0].mesh, body[1].mesh and 17 more"
    assert not any("not watertight (" in note for note in scene.notes)


def test_the_light_buoy(real_folder: Path) -> None:
    scene = load_scene({"body": [{"name": "buoy", "mesh": "light_buoy.stl"}]}, folder=real_folder)
    mesh = scene.bodies[0].mesh
    assert mesh is not None and len(mesh.faces) == 8722  # as its provenance says
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([1.6, 1.6, 2.1], abs=0.05)  # m: printed digits
    assert scene.notes == (
        "body[0].mesh: light_buoy.stl: not watertight (416 open edges), 32 edges shared by more than two triangles",
    )
