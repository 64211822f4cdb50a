"""STL files, binary and ASCII. trimesh parses the latter."""

import re
import struct
from functools import partial

import numpy as np

from radar_service.scene_file.readers.file_format import Format, Triangles, check_face_count
from radar_service.scene_file.readers.trimesh_parser import exported_box, trimesh_triangles


def declared_size(content: bytes) -> int:
    """Returns the size that a binary STL declares: 80 bytes of header, a count, 50 bytes per face. -1 if it has no header."""
    return 84 + 50 * int(struct.unpack_from("<I", content, 80)[0]) if len(content) >= 84 else -1


def cut_or_padded(content: bytes) -> str:
    """Returns words for a binary STL that is longer or shorter than it declares; empty for other content."""
    if len(content) < 84 or not 0.5 < declared_size(content) / len(content) < 2.0:
        return ""
    return f"stl cut short or padded ({len(content)} bytes, not {declared_size(content)})"


def _is_binary(content: bytes) -> bool:
    return declared_size(content) == len(content)


def _is_ascii(content: bytes) -> bool:
    return re.match(rb"\s*solid\b", content[:4096]) is not None and b"facet" in content[:65536]


def _check_binary(content: bytes, location: str) -> None:
    check_face_count((len(content) - 84) // 50, location)


def _binary_triangles(content: bytes, location: str) -> Triangles:
    """Returns the corners of all facets, three to each."""
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    corners = np.frombuffer(content, facet, offset=84)["corners"].reshape(-1, 3)
    return corners.astype(np.float64), np.arange(len(corners)).reshape(-1, 3)


BINARY = Format[Triangles]("stl", _is_binary, _binary_triangles, lambda: (exported_box("stl"),), _check_binary)
ASCII = Format[Triangles](
    "stl_ascii", _is_ascii, partial(trimesh_triangles, "stl_ascii"), lambda: (exported_box("stl_ascii"),)
)
FORMATS = (BINARY, ASCII)  # binary files may begin with the word "solid" too
