"""The limited process that parses files for the sandbox: python -m radar_service.scene.sandbox_child BYTES SECONDS.

Standard input brings requests, standard output takes answers; each is a length (eight bytes, little-endian) and a body. A
request is a pickled tuple of the parent's making; an answer is JSON (problems, findings, shapes) and then the raw arrays.
"""

import io
import json
import os
import pickle
import struct
import sys
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

from radar_service.scene.builder import InProcess
from radar_service.scene.error import SceneError
from radar_service.scene.heightmap import Sight
from radar_service.scene.model import BodyModel
from radar_service.scene.sandbox import MAX_TRIANGLES

if sys.platform != "win32":  # which has no such limits: there only the parent's patience bounds a file
    import resource

BUILD = InProcess()


def warm_up() -> None:
    """Parse one small file of every kind: what a parser imports or opens must be there before nothing may be opened."""
    box = trimesh.creation.box()
    exports = [(ending, box.export(file_type=ending)) for ending in ("glb", "stl", "ply", "obj")]
    exports += [("stl", box.export(file_type="stl_ascii")), ("ply", box.export(file_type="ply", encoding="ascii"))]
    for ending, exported in exports:
        content = exported if isinstance(exported, bytes) else exported.encode()
        BUILD.mesh(content, f"box.{ending}", "warm", 1.0, "z")
    picture = Image.fromarray(np.full((140, 140), 40_000, dtype=np.uint16))
    body = BodyModel(
        name="warm", heightmap="x.tif", low_m=0, high_m=9, south_west_deg=(50, 1), north_east_deg=(50.1, 1.1)
    )  # fmt: skip
    for ending, options in (
        ("png", {}), ("tif", {}), ("tif", {"compression": "tiff_lzw"}), ("tif", {"compression": "tiff_adobe_deflate"}),
    ):  # fmt: skip
        file = io.BytesIO()
        picture.save(file, "PNG" if ending == "png" else "TIFF", **options)
        BUILD.terrain(file.getvalue(), f"x.{ending}", body, np.zeros(3), (50.0, 1.0), Sight(0, 0, 1e5), "warm")


def limit(memory: int) -> None:
    """Memory from here on, and nothing new: no file, no socket, no process, no dump."""
    if sys.platform == "win32":
        return
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() if sys.platform == "linux" else 0
    for what, most in (
        (resource.RLIMIT_AS, taken + memory), (resource.RLIMIT_FSIZE, 0), (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NPROC, 0), (resource.RLIMIT_NOFILE, 3),
    ):  # fmt: skip
        resource.setrlimit(what, (most, most))


def limit_processor(seconds: float) -> None:
    """Processor time for the next file, whatever earlier ones took."""
    if sys.platform != "win32":
        used = resource.getrusage(resource.RUSAGE_SELF)
        hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
        resource.setrlimit(resource.RLIMIT_CPU, (int(used.ru_utime + used.ru_stime + seconds) + 1, hard))


def answer(request: tuple[Any, ...]) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """The head of the answer to a request, and its arrays. `spent`: this process should not take another file."""
    head: dict[str, Any] = {"problems": [], "findings": [], "arrays": {}}
    kind, content, name, *rest = request
    place = rest[0] if kind == "mesh" else f"{rest[-1]}.heightmap: {name}"
    try:
        arrays, findings = _built(kind, content, name, rest, place)
    except SceneError as fault:
        return head | {"problems": list(fault.problems)}, []
    except MemoryError:
        return head | {"problems": [f"{place}: takes too much memory to read; make it smaller"], "spent": True}, []
    except Exception as fault:  # parsers of arbitrary bytes raise whatever they like
        line = f"{place}: cannot be read ({type(fault).__name__}: {str(fault)[:120]}); export it again"
        return head | {"problems": [line], "spent": True}, []
    return head | {"findings": findings, "arrays": {key: list(a.shape) for key, a in arrays.items()}}, list(arrays.values())


def _built(
    kind: str, content: bytes, name: str, rest: list[Any], place: str
) -> tuple[dict[str, NDArray[Any]], tuple[str, ...]]:
    more: dict[str, NDArray[Any]] = {}
    if kind == "mesh":
        loaded = BUILD.mesh(content, name, *rest)
    else:
        terrain = BUILD.terrain(content, name, *rest)
        loaded, more = terrain.loaded, {"position": terrain.position.astype("<f8")}
    mesh = loaded.mesh
    if len(mesh.faces) > MAX_TRIANGLES:
        raise SceneError(
            f"{place}: {len(mesh.faces)} triangles; at most {MAX_TRIANGLES} are taken from an upload: simplify it"
        )
    return {"vertices": mesh.vertices.astype("<f8"), "faces": mesh.faces.astype("<i8")} | more, loaded.findings


def serve(inbound: BinaryIO, outbound: BinaryIO, seconds: float) -> None:
    """Answer requests until there are no more."""
    while len(size := inbound.read(8)) == 8:
        request = inbound.read(struct.unpack("<Q", size)[0])
        limit_processor(seconds)
        head, arrays = answer(pickle.loads(request))
        text = json.dumps(head).encode()
        outbound.write(struct.pack("<Q", len(text)) + text)
        for array in arrays:
            outbound.write(np.ascontiguousarray(array).data)
        outbound.flush()


if __name__ == "__main__":
    warm_up()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a parser prints is no answer
    limit(int(sys.argv[1]))
    serve(sys.stdin.buffer, answers, float(sys.argv[2]))
