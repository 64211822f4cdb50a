"""GLB files: their chunks and their JSON are checked here; trimesh parses them.

Declared counts are compared with bytes before a parser allocates memory. The caller turns errors of containers into SceneError.
"""

import json
import struct
from functools import partial
from typing import Any

from radar_service.scene_file.readers.file_format import Format, Triangles, check_face_count
from radar_service.scene_file.readers.trimesh_parser import exported_box, trimesh_triangles
from radar_service.world import SceneError

MAX_JSON_BYTES = 20 * 2**20
MAX_NODES = 100_000
MAX_DEPTH = 100
MAX_UNPACKED = 2**30  # bytes of all accessors together, which may overlap in the buffer
COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # glTF 2.0, section 3.6.2.2
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "KHR_mesh_quantization")


def _check_glb(content: bytes, location: str) -> None:
    """Raises SceneError if lengths disagree with the file, or the JSON declares more than the buffer holds."""
    if len(content) < 20 or struct.unpack_from("<II", content, 4) != (2, len(content)):
        raise SceneError(
            f"{location}: the header is not that of GLB version 2 with {len(content)} bytes; export the file again"
        )
    chunks: dict[bytes, tuple[int, int]] = {}
    at = 12
    while at + 8 <= len(content):
        size, kind = struct.unpack_from("<I4s", content, at)
        if at + 8 + size > len(content):
            raise SceneError(
                f"{location}: a chunk declares {size} bytes, {len(content) - at - 8} are left; export the file again"
            )
        chunks.setdefault(kind, (at + 8, size))
        at += 8 + size
    start, size = chunks.get(b"JSON", (0, 0))
    if not 0 < size <= MAX_JSON_BYTES:
        raise SceneError(
            f"{location}: the JSON chunk has {size} bytes; 1 to {MAX_JSON_BYTES} are allowed: export the file again"
        )
    try:
        tree = json.loads(content[start : start + size])
    except (ValueError, RecursionError) as error:
        raise SceneError(f"{location}: the JSON is invalid ({str(error)[:100]}); export the file again") from None
    try:
        faces = check_gltf(tree, chunks.get(b"BIN\0", (0, 0))[1], location)
    except (KeyError, TypeError, IndexError, AttributeError, ValueError, OverflowError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(
            f"{location}: the JSON is not glTF ({type(error).__name__}: {str(error)[:100]}); export it again"
        ) from None
    check_face_count(faces, location)


FORMAT = Format[Triangles](
    "glb", lambda content: content.startswith(b"glTF"), partial(trimesh_triangles, "glb"), lambda: (exported_box("glb"),),
    _check_glb,
)  # fmt: skip


def check_gltf(tree: dict[str, Any], buffer_bytes: int, location: str) -> int:
    """Returns the number of triangles of all placed meshes. Raises SceneError for declarations that cannot be true."""
    _check_references(tree, location)
    views = tree.get("bufferViews", [])
    sizes = [_view_bytes(view, buffer_bytes, location) for view in views]
    total = sum(_accessor_bytes(accessor, views, sizes, location) for accessor in tree.get("accessors", []))
    if total > MAX_UNPACKED:
        raise SceneError(
            f"{location}: its accessors unpack to {total} bytes; at most {MAX_UNPACKED} are allowed: simplify the mesh"
        )
    faces = [sum(_faces(primitive, tree, location) for primitive in mesh["primitives"]) for mesh in tree.get("meshes", [])]
    _check_tree(tree, location)
    return sum(faces[_index(node["mesh"], len(faces))] for node in tree.get("nodes", []) if "mesh" in node)


def _check_references(tree: dict[str, Any], location: str) -> None:
    for extension in tree.get("extensionsRequired", []):
        if not extension.startswith(HARMLESS):
            raise SceneError(
                f'{location}: the file needs the extension "{extension[:60]}"; export it without compression or extensions'
            )
    for buffer in tree.get("buffers", []):
        if "uri" in buffer:
            raise SceneError(
                f'{location}: the file keeps data outside ("{str(buffer["uri"])[:60]}"); export it with everything embedded'
            )
    if len(tree.get("buffers", [])) > 1:
        raise SceneError(f"{location}: the file has {len(tree['buffers'])} buffers; a GLB file holds one: export it again")


def _index(value: Any, count: int) -> int:
    """Returns `value` if it is an index from 0 to `count` - 1. Raises IndexError otherwise."""
    if type(value) is not int or not 0 <= value < count:
        raise IndexError(f"index {str(value)[:20]} of {count}")
    return value


def _count(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise ValueError(f"{str(value)[:20]} is not a count")
    return value


def _view_bytes(view: dict[str, Any], buffer_bytes: int, location: str) -> int:
    start, size = _count(view.get("byteOffset", 0)), _count(view["byteLength"])
    if start + size > buffer_bytes:
        raise SceneError(f"{location}: a buffer view ends at byte {start + size} of {buffer_bytes}; export the file again")
    _count(view.get("byteStride", 0))
    return size


def _accessor_bytes(accessor: dict[str, Any], views: list[dict[str, Any]], sizes: list[int], location: str) -> int:
    """Returns the unpacked size [bytes] of an accessor. Raises SceneError if it ends outside its buffer view."""
    if "bufferView" not in accessor or "sparse" in accessor:
        raise SceneError(
            f"{location}: an accessor is sparse or has no buffer view; export it without compression or morphing"
        )
    view = _index(accessor["bufferView"], len(views))
    count, start = _count(accessor["count"]), _count(accessor.get("byteOffset", 0))
    element = COMPONENT_BYTES[accessor["componentType"]] * COMPONENTS[accessor["type"]]
    stride = views[view].get("byteStride") or element
    end = start + (stride * (count - 1) + element if count else 0)
    if end > sizes[view] or stride < element:
        raise SceneError(
            f"{location}: an accessor of {count} elements ends at byte {end} of {sizes[view]}; export the file again"
        )
    return count * element


def _faces(primitive: dict[str, Any], tree: dict[str, Any], location: str) -> int:
    mode = primitive.get("mode", 4)
    if mode in (0, 1, 2, 3):
        return 0  # points and lines
    if mode != 4:
        raise SceneError(
            f"{location}: the file holds triangle strips or fans (mode {str(mode)[:20]}); export plain triangles"
        )
    accessors = tree["accessors"]
    position = accessors[_index(primitive["attributes"]["POSITION"], len(accessors))]
    if position["type"] != "VEC3":
        raise SceneError(
            f"{location}: positions have the type {str(position['type'])[:20]}, not VEC3; export the file again"
        )
    if "indices" not in primitive:
        return int(position["count"]) // 3
    indices = accessors[_index(primitive["indices"], len(accessors))]
    if indices["type"] != "SCALAR" or indices["componentType"] not in (5121, 5123, 5125):
        raise SceneError(f"{location}: vertex numbers are not whole; export the file again")
    return int(indices["count"]) // 3


def _check_tree(tree: dict[str, Any], location: str) -> None:
    """Raises SceneError unless the nodes form trees of limited depth: a cycle would be unpacked without end."""
    nodes = tree.get("nodes", [])
    if len(nodes) > MAX_NODES:
        raise SceneError(f"{location}: the file has {len(nodes)} nodes; at most {MAX_NODES} are allowed: join its parts")
    parent: dict[int, int] = {}
    for k, node in enumerate(nodes):
        for child in node.get("children", []):
            if parent.setdefault(_index(child, len(nodes)), k) != k:
                raise SceneError(f"{location}: node {child} has two parents; nodes form a tree: export the file again")
    for scene in tree.get("scenes", []):
        for root in scene.get("nodes", []):
            _index(root, len(nodes))
    for k in range(len(nodes)):
        depth, at = 0, k
        while at in parent and depth <= MAX_DEPTH:
            depth, at = depth + 1, parent[at]
        if depth > MAX_DEPTH:
            raise SceneError(
                f"{location}: nodes are nested more than {MAX_DEPTH} deep or in a circle; export the file again"
            )
