"""GLB files whose chunks are not what they declare are refused."""

import struct

from tests.scene_file.readers.mesh_files import exported, refused


def test_glb_lengths() -> None:
    content = exported("glb")
    assert "a chunk declares 4294967295 bytes" in refused(content[:12] + b"\xff\xff\xff\xff" + content[16:], "a.glb")
    assert "not that of GLB version 2" in refused(content[:-4], "a.glb")
    assert "not that of GLB version 2" in refused(b"glTF" + struct.pack("<II", 2, 12), "a.glb")
    deep = b"[" * 100_000
    head = b"glTF" + struct.pack("<II", 2, 20 + len(deep)) + struct.pack("<I4s", len(deep), b"JSON")
    assert "the JSON is invalid" in refused(head + deep, "a.glb")
