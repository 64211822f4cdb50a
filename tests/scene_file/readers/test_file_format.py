"""What all formats share: limits of counts, ranges of vertex numbers, and the refusal of what a parser cannot read."""

import numpy as np
import pytest

from radar_service.scene_file.readers.file_format import MAX_FACES, check_face_count, check_range, refusals
from radar_service.world.error import SceneError


def test_five_million_triangles_are_allowed() -> None:
    check_face_count(MAX_FACES, "m")
    with pytest.raises(SceneError, match="^m: the mesh has 5000001 triangles; at most 5000000 are allowed: simplify it$"):
        check_face_count(MAX_FACES + 1, "m")


@pytest.mark.parametrize(("faces", "refused"), [([[0, 1, 2]], False), ([[0, 1, 3]], True), ([[-1, 1, 2]], True)])
def test_faces_refer_to_vertices_that_are_there(faces: list[list[int]], refused: bool) -> None:
    if not refused:
        return check_range(np.zeros((3, 3)), np.array(faces), "m")
    with pytest.raises(SceneError, match="^m: faces refer to vertices .*, but there are only 3 "):
        check_range(np.zeros((3, 3)), np.array(faces), "m")


def test_points_on_a_plane_are_refused_only_where_faces_need_them() -> None:
    check_range(np.zeros((3, 2)), np.zeros((0, 3), dtype=np.int64), "m")
    with pytest.raises(SceneError, match="not points in space"):
        check_range(np.zeros((3, 2)), np.array([[0, 1, 2]]), "m")


def test_a_refusal_is_one_line_with_the_reason_if_there_is_one() -> None:
    for error, reason in ((ValueError("a\nb"), "ValueError: a b"), (KeyError(), "KeyError")):
        with pytest.raises(SceneError) as refused, refusals("ply", "m"):
            raise error
        assert str(refused.value) == f"m: the file is not readable as PLY ({reason}); export it again"
    with pytest.raises(MemoryError), refusals("ply", "m"):
        raise MemoryError
