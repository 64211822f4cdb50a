"""The process that parses files for the sandbox: python -m radar_service.scene_file.readers.sandbox_child BYTES SECONDS.

It reads requests from standard input and writes answers to standard output. Each is a length (eight bytes,
little-endian) and a body. A request is a BodyFile that the parent pickled; an answer is JSON (problems; of each body its name,
findings and shapes of arrays), then the raw arrays.
"""

import contextlib
import json
import os
import pickle
import struct
import sys
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from radar_service.processes.limits import forbid_access, limit_memory, limit_processor_time
from radar_service.scene_file.readers.file_format import IN_PROCESS, BodyFile, LoadedBody, MeshReader
from radar_service.scene_file.readers.heightmap import HeightMapFile
from radar_service.scene_file.readers.mesh import MeshFile
from radar_service.scene_file.readers.sandbox import DTYPES, MAX_TRIANGLES
from radar_service.world import SceneError

Arrays = dict[str, NDArray[Any]]


def warm_up() -> None:
    """Reads one small file of each format, so that parsers import and open what they need before the limits apply."""
    for kind in (MeshFile, HeightMapFile):
        for example in kind.examples():
            with contextlib.suppress(Exception):  # of a stranger's reader
                example.read()


def answer(file: BodyFile, reader: MeshReader) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Returns the header and the arrays of the answer to a request. `exhausted` means: replace this process."""
    header: dict[str, Any] = {"problems": [], "bodies": []}
    try:
        bodies = reader.read(file)
        _check_size(bodies, file.location)
    except SceneError as error:
        return header | {"problems": list(error.problems)}, []
    except MemoryError:
        line = f"{file.location}: the file takes too much memory to read; make it smaller"
        return header | {"problems": [line], "exhausted": True}, []
    except Exception as error:  # parsers of arbitrary bytes raise any exception
        reason = f"{type(error).__name__}: {str(error)[:120]}"
        line = f"{file.location}: the file cannot be read ({reason}); export it again"
        return header | {"problems": [line], "exhausted": True}, []
    arrays = [_arrays(body) for body in bodies]
    described = [
        {"name": body.name, "findings": body.findings, "arrays": {key: a.shape for key, a in of_body.items()}}
        for body, of_body in zip(bodies, arrays, strict=True)
    ]
    return header | {"bodies": described}, [array for of_body in arrays for array in of_body.values()]


def _check_size(bodies: tuple[LoadedBody, ...], location: str) -> None:
    count = sum(len(body.mesh.faces) for body in bodies)
    if count > MAX_TRIANGLES:
        raise SceneError(
            f"{location}: the mesh has {count} triangles; an upload may have at most {MAX_TRIANGLES}: simplify it"
        )


def _arrays(body: LoadedBody) -> Arrays:
    """Returns the arrays of a body by their names, in the types in which they are sent."""
    arrays: Arrays = {"vertices": body.mesh.vertices, "faces": body.mesh.faces}
    if body.position is not None:
        arrays["position"] = body.position
    return {key: array.astype(DTYPES[key]) for key, array in arrays.items()}


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
    limit_memory(int(sys.argv[1]))
    forbid_access()
    serve(sys.stdin.buffer, answers, float(sys.argv[2]))
