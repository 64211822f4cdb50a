"""GLB files whose JSON declares what cannot be true are refused."""

import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh

from radar_service.scene_file.readers.glb import check_gltf
from radar_service.world.error import SceneError
from tests.scene_file.readers.mesh_files import chain, glb_with, refused


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda t: t["accessors"][0].update(count=2**30), "ends at byte"),
        (lambda t: t["accessors"][0].update(count=-3), "-3 is not a count"),
        (lambda t: t["accessors"][0].update(count=1.5), "1.5 is not a count"),
        (lambda t: t["accessors"][0].pop("bufferView"), "has no buffer view"),
        (lambda t: t["accessors"][0].update(sparse={"count": 1}), "is sparse"),
        (lambda t: t["accessors"][0].update(componentType=7), "is not glTF"),
        (lambda t: t["bufferViews"][0].update(byteLength=10**12), "a buffer view ends at byte"),
        (lambda t: t["bufferViews"][0].update(byteOffset=-4), "-4 is not a count"),
        (lambda t: t["buffers"][0].update(uri="../secret.bin"), 'keeps data outside ("../secret.bin")'),
        (lambda t: t["buffers"][0].update(uri="file:///etc/passwd"), "keeps data outside"),
        (lambda t: t["buffers"].append({"byteLength": 4}), "has 2 buffers"),
        (lambda t: t.update(extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"),
        (lambda t: t["meshes"][0]["primitives"][0].update(mode=5), "strips or fans"),
        (lambda t: t["meshes"][0]["primitives"][0].update(mode=0), "no triangles"),
        (lambda t: t["meshes"][0]["primitives"][0].update(indices=99), "is not glTF"),
        (lambda t: t["meshes"][0]["primitives"][0]["attributes"].pop("POSITION"), "is not glTF"),
        (lambda t: t["nodes"].extend([{}] * 100_001), "nodes; at most 100000"),
        (chain, "more than 100 deep or in a circle"),
        (lambda t: t.update(nodes=[{"children": [1]}, {"children": [0], "mesh": 0}]), "more than 100 deep or in a circle"),
        (lambda t: t.update(nodes=[{"children": [2]}, {"children": [2]}, {"mesh": 0}]), "has two parents"),
        (lambda t: t.update(nodes=7), "is not glTF"),
    ],
)
def test_bad_glb_files(change: Callable[[dict[str, Any]], object], message: str) -> None:
    assert message in refused(glb_with(change), "a.glb")


def test_instances_count_as_often_as_they_are_placed() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=4)  # 5120 triangles
    scene = trimesh.Scene()
    scene.add_geometry(sphere, geom_name="s")
    for k in range(999):
        scene.add_geometry(sphere, geom_name="s", node_name=f"n{k}", transform=np.eye(4))
    content = scene.export(file_type="glb")
    count = json.loads(content[20 : 20 + struct.unpack_from("<I", content, 12)[0]])["nodes"]
    copies = sum("mesh" in node for node in count)
    message = refused(content, "a.glb")
    assert f"{copies * 5120} triangles; at most 5000000" in message


def test_accessors_that_share_bytes_are_summed() -> None:
    """1100 accessors over one megabyte unpack to more than a gigabyte, whatever the file's size."""
    accessor = {"bufferView": 0, "componentType": 5126, "type": "SCALAR", "count": 2**18}
    tree = {"buffers": [{}], "bufferViews": [{"byteLength": 2**20}], "accessors": [accessor] * 1100}
    with pytest.raises(SceneError, match="its accessors unpack to 1153433600 bytes"):
        check_gltf(tree, 2**20, "m")
