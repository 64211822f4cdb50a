"""Slices of large meshes, and whether these are closed, against the search by sorted edges."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.mesh_quality import outward_side
from radar_service.world import large_mesh
from radar_service.world.body import Mesh
from radar_service.world.large_mesh import SLICES, mesh_sample, outward_winding, row_marks
from radar_service.world.shapes import sphere


def test_a_small_mesh_is_judged_as_it_is_and_of_a_large_one_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    ball = sphere(10.0, 0.004)
    assert mesh_sample(ball) is ball
    monkeypatch.setattr(large_mesh, "MAX_JUDGED", 40 * SLICES)
    part = mesh_sample(Mesh(ball.vertices * [1.0, 9.0, 1.0], ball.faces))
    assert len(part.faces) == 40 * SLICES and len(part.vertices) < 2 * len(part.faces)
    first = np.sort(part.vertices[part.faces[:, 0], 1])
    assert first[0] < -85.0 and first[-1] > 85.0
    assert (np.diff(first) > 0.5).sum() >= SLICES - 1  # gaps between the slices
    assert {tuple(row) for row in part.vertices} <= {tuple(row) for row in ball.vertices * [1.0, 9.0, 1.0]}


@pytest.mark.parametrize("welded", [True, False])
def test_a_closed_mesh_is_found_without_a_sort(welded: bool) -> None:
    """As it is, turned inside out, with a hole, with one triangle wound the other way; corners shared or not."""
    ball = sphere(3.0)
    flipped = ball.faces.copy()
    flipped[7] = flipped[7, ::-1]
    for faces, expected in ((ball.faces, 1), (ball.faces[:, ::-1], -1), (ball.faces[1:], 0), (flipped, 0)):
        mesh = Mesh(ball.vertices, faces)
        if not welded:
            mesh = Mesh(ball.vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
        assert outward_winding(mesh) == expected
        assert set(outward_side(mesh).tolist()) == {expected}


def test_equal_rows_have_equal_marks() -> None:
    rows = np.random.default_rng(1).integers(-9, 9, (5000, 3)) / 8.0
    rows[::7] *= -1.0  # some zeros are negative
    marks = row_marks(rows)
    number = np.unique(rows + 0.0, axis=0, return_inverse=True)[1].ravel()
    assert len(np.unique(marks)) == number.max() + 1 == len(np.unique(np.stack([marks, number.astype(np.uint64)]), axis=1).T)
