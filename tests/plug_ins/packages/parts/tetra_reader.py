"""Files of tetrahedra: a line "tetra", then of each its name, east, north, up and edge [m]."""

import numpy as np

from radar_service.scene_file.readers.file_format import FileBody, Format

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def parse(content: bytes, location: str) -> list[FileBody]:
    bodies = []
    for line in content.decode().splitlines()[1:]:
        name, *numbers = line.split()
        east, north, up, edge = map(float, numbers)
        bodies.append(FileBody(edge * CORNERS, FACES, name, (east, north, up)))
    return bodies


FORMAT = Format("tetra", lambda content: content.startswith(b"tetra"), parse, lambda: (b"tetra\na 0 0 0 1",))
