"""Height maps that tests share."""

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from radar_service.scene_file.load import load_scene
from radar_service.world.body import Body, Mesh
from radar_service.world.scene import Scene

ORIGIN = {"latitude_deg": 50.9, "longitude_deg": 1.4}


def npy(samples: NDArray[Any]) -> bytes:
    file = io.BytesIO()
    np.save(file, samples)
    return file.getvalue()


def picture(samples: NDArray[Any], kind: str = "PNG", **options: Any) -> bytes:
    file = io.BytesIO()
    Image.fromarray(samples).save(file, kind, **options)
    return file.getvalue()


def load(folder: Path, name: str, content: bytes, range_max_m: float = 50_000, **keys: Any) -> Scene:
    (folder / name).write_bytes(content)
    body = {"name": "island", "heightmap": name, "material": "land", **keys}
    return load_scene(
        {"origin": ORIGIN, "radar": {"range_max_m": range_max_m, "bandwidth_hz": 5e6}, "body": [body]}, folder=folder
    )


def land_vertices(mesh: Mesh) -> NDArray[np.float64]:
    """The vertices of the land itself: those of triangles that look up, not of the skirt's."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return mesh.vertices[
        np.unique(mesh.faces[np.cross(b - a, c - a)[:, 2] > 1e-9 * area])
    ]  # 1e-9: rounding of a wall's lean


def world_vertices(body: Body) -> NDArray[np.float64]:
    """The vertices of the land on the map [m]."""
    assert body.mesh is not None
    return land_vertices(body.mesh) + body.motion.position[0]
