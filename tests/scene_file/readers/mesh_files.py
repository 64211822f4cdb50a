"""Mesh files, and their refusal, that tests share."""

import json
import struct
from collections.abc import Callable
from typing import Any

import pytest
import trimesh

from radar_service.scene_file.readers.file_format import LoadedBody
from radar_service.scene_file.readers.mesh import MeshFile
from radar_service.world.error import SceneError

CUBE = trimesh.creation.box((1.0, 2.0, 3.0))


def mesh_from_bytes(
    content: bytes, name: str, location: str, scale: float | None = None, up: str | None = None
) -> LoadedBody:
    (body,) = MeshFile(content, name, location, scale, up).read()
    return body


def exported(kind: str, **options: Any) -> bytes:
    content = CUBE.export(file_type=kind, **options)
    return content.encode() if isinstance(content, str) else bytes(content)


def stl_claiming(count: int) -> bytes:
    return exported("stl")[:80] + struct.pack("<I", count) + exported("stl")[84:]


def glb_with(change: Callable[[dict[str, Any]], object]) -> bytes:
    """The cube as GLB with its JSON changed."""
    content = exported("glb")
    size = struct.unpack_from("<I", content, 12)[0]
    tree = json.loads(content[20 : 20 + size])
    change(tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + size :]
    return (
        b"glTF" + struct.pack("<II", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest
    )


def chain(tree: dict[str, Any]) -> None:
    count = 20_000
    tree["nodes"] = [{"children": [k + 1]} for k in range(count)] + [{"mesh": 0}]
    tree["scenes"] = [{"nodes": [0]}]


def refused(content: bytes, name: str) -> str:
    with pytest.raises(SceneError) as caught:
        mesh_from_bytes(content, name, "body[0].mesh: a")
    assert str(caught.value).startswith("body[0].mesh: a")
    return str(caught.value)
