"""The plan view of a body, for any origin of its mesh."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.world.body import Mesh
from tests.scenes import point, scene

CORNERS = [[90.0, 40.0, -1.0], [110.0, 40.0, 3.0], [110.0, 80.0, 7.0], [90.0, 80.0, 5.0]]

FACES = np.array([[0, 1, 2], [0, 2, 3]])


def test_plan_of_a_mesh_far_from_its_origin() -> None:
    """A rectangle of 20 x 40 m about (100, 60): half its diagonal, and its far corner's distance; vertices that no triangle
    uses do not count. Heading east turns its north side to the east: (100, 60) goes to (60, -100)."""
    made = scene([point("b", 1000, 2000, heading_deg=90)])
    mesh = Mesh(np.array([*CORNERS, [1e6, 0.0, 0.0]]), FACES)
    body = replace(made.bodies[0], mesh=mesh)
    np.testing.assert_array_equal(body.middle, [100.0, 60.0, 0.0])
    assert body.radius == pytest.approx(np.hypot(10, 20)) and body.arm == pytest.approx(np.hypot(110, 80))
    assert body.middle_at(7.0)[:2] == pytest.approx([1060.0, 1900.0])


def test_plan_of_a_point() -> None:
    body = scene([point("b", 1, 2, course_deg=90, speed_kn=10)]).bodies[0]
    assert body.radius == body.arm == 0.0 and not body.middle.any()
    assert body.middle_at(10.0)[:2] == pytest.approx([1 + 10 * 10 * 1852 / 3600, 2.0])
