"""The process that parses files for the sandbox: python -m radar_service.scene_file.readers.sandbox_child BYTES SECONDS.

It reads requests from standard input and writes answers to standard output. Each is a length (eight bytes,
little-endian) and a body. A request is a tuple that the parent pickled; an answer is JSON (problems, findings, shapes),
then the raw arrays.
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

from radar_service.processes.processor_time import limit_processor_time
from radar_service.scene_file.model.scene import BodyModel
from radar_service.scene_file.readers.heightmap import Coverage
from radar_service.scene_file.readers.mesh_reader import IN_PROCESS, MeshReader
from radar_service.scene_file.readers.sandbox import MAX_TRIANGLES
from radar_service.world.error import SceneError

if sys.platform != "win32":  # Windows has no such limits; only the backstop of the parent applies
    import resource


def warm_up() -> None:
    """Parses one small file of each format, so that parsers import and open what they need before the limits apply."""
    box = trimesh.creation.box()
    exports = [(ending, box.export(file_type=ending)) for ending in ("glb", "stl", "ply", "obj")]
    exports += [("stl", box.export(file_type="stl_ascii")), ("ply", box.export(file_type="ply", encoding="ascii"))]
    for ending, exported in exports:
        content = exported if isinstance(exported, bytes) else exported.encode()
        IN_PROCESS.mesh(content, f"box.{ending}", "warm-up", 1.0, "z")
    picture = Image.fromarray(np.full((140, 140), 40_000, dtype=np.uint16))
    body = BodyModel(
        name="warm", heightmap="x.tif", low_m=0, high_m=9, south_west_deg=(50, 1), north_east_deg=(50.1, 1.1)
    )  # fmt: skip
    for ending, options in (
        ("png", {}), ("tif", {}), ("tif", {"compression": "tiff_lzw"}), ("tif", {"compression": "tiff_adobe_deflate"}),
    ):  # fmt: skip
        file = io.BytesIO()
        picture.save(file, "PNG" if ending == "png" else "TIFF", **options)
        IN_PROCESS.terrain(file.getvalue(), f"x.{ending}", body, np.zeros(3), (50.0, 1.0), Coverage(0, 0, 1e5), "warm-up")


def limit_process(memory: int) -> None:
    """Limits this process to `memory` [bytes] more than now, and forbids new files, sockets, processes and core dumps."""
    if sys.platform == "win32":
        return
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() if sys.platform == "linux" else 0
    for resource_kind, maximum in (
        (resource.RLIMIT_AS, used + memory), (resource.RLIMIT_FSIZE, 0), (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NPROC, 0), (resource.RLIMIT_NOFILE, 3),
    ):  # fmt: skip
        resource.setrlimit(resource_kind, (maximum, maximum))


def answer(request: tuple[Any, ...], reader: MeshReader) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Returns the header and the arrays of the answer to a request. `exhausted` means: replace this process."""
    header: dict[str, Any] = {"problems": [], "findings": [], "arrays": {}}
    kind, content, name, *rest = request
    location = rest[0] if kind == "mesh" else f"{rest[-1]}.heightmap: {name}"
    try:
        arrays, findings = _read(reader, kind, content, name, rest, location)
    except SceneError as error:
        return header | {"problems": list(error.problems)}, []
    except MemoryError:
        return header | {
            "problems": [f"{location}: the file takes too much memory to read; make it smaller"],
            "exhausted": True,
        }, []
    except Exception as error:  # parsers of arbitrary bytes raise any exception
        line = f"{location}: the file cannot be read ({type(error).__name__}: {str(error)[:120]}); export it again"
        return header | {"problems": [line], "exhausted": True}, []
    return header | {"findings": findings, "arrays": {key: list(a.shape) for key, a in arrays.items()}}, list(
        arrays.values()
    )


def _read(
    reader: MeshReader, kind: str, content: bytes, name: str, rest: list[Any], location: str
) -> tuple[dict[str, NDArray[Any]], tuple[str, ...]]:
    extra: dict[str, NDArray[Any]] = {}
    if kind == "mesh":
        loaded = reader.mesh(content, name, *rest)
    else:
        terrain = reader.terrain(content, name, *rest)
        loaded, extra = terrain.loaded, {"position": terrain.position.astype("<f8")}
    mesh = loaded.mesh
    if len(mesh.faces) > MAX_TRIANGLES:
        raise SceneError(
            f"{location}: the mesh has {len(mesh.faces)} triangles; an upload may have at most {MAX_TRIANGLES}: simplify it"
        )
    return {"vertices": mesh.vertices.astype("<f8"), "faces": mesh.faces.astype("<i8")} | extra, loaded.findings


def serve(inbound: BinaryIO, outbound: BinaryIO, seconds: float, reader: MeshReader = IN_PROCESS) -> None:
    """Answers requests until the input ends. seconds: processor time for each file, from here on [s]."""
    while len(size := inbound.read(8)) == 8:
        request = inbound.read(struct.unpack("<Q", size)[0])
        limit_processor_time(seconds)
        header, arrays = answer(pickle.loads(request), reader)
        text = json.dumps(header).encode()
        outbound.write(struct.pack("<Q", len(text)) + text)
        for array in arrays:
            outbound.write(np.ascontiguousarray(array).data)
        outbound.flush()


if __name__ == "__main__":
    warm_up()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a parser prints goes to standard error
    limit_process(int(sys.argv[1]))
    serve(sys.stdin.buffer, answers, float(sys.argv[2]))
