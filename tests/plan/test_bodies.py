"""The lines of a plan about bodies, from statistics made by hand."""

import numpy as np
import pytest

import radar_service as rs
from radar_service.plan.culling import CulledBody
from radar_service.plan.plan import NEVER_VISIBLE, bodies
from radar_service.plan.statistics import Costs, EngineStatistics, PerBody
from radar_service.records.fidelity import PRESETS
from radar_service.records.plan_item import PlanItem
from tests.scenes import point, scene

COSTS = Costs(1.0, 60.0, 4.0, 32.0)
BOX = {"name": "box", "shape": "box", "length_m": 40, "width_m": 12, "height_m": 9, "position_m": [300, 700, 0],
       "material": "concrete", "scattering": "diffuse"}  # fmt: skip


def made() -> rs.Scene:
    """A box at rest, a moving point, a moving box and a point at rest."""
    way = {"speed_kn": 5, "course_deg": 0}
    return scene([BOX, point("mover", 0, 500, **way), BOX | {"name": "ship"} | way, point("buoy", 0, 900)])


def per_body(scatterers: list[int], echoes: list[int]) -> EngineStatistics:
    return EngineStatistics(costs=COSTS, bodies=PerBody(np.array(scatterers), np.array(echoes)))


def items(statistics: EngineStatistics, name: str = "balanced") -> list[PlanItem]:
    return bodies(made(), PRESETS[name], statistics)


def test_moving_bodies_share_the_cost_of_moving_echoes_by_their_echoes() -> None:
    """60 us for 1 + 5 echoes; bodies at rest cost nothing."""
    result = items(per_body([100, 1, 50, 1], [40, 1, 5, 1]))
    assert [item.microseconds for item in result] == pytest.approx([0.0, 10.0, 50.0, 0.0])


def test_scatterers_and_echoes_are_stated() -> None:
    result = items(per_body([100, 1, 50, 1], [40, 0, 5, 1]))
    assert result[0].how.endswith("; 100 points, 40 echoes") and "computed once" in result[0].how
    assert result[1].how.endswith("; a point, not visible now") and "computed at each azimuth" in result[1].how
    assert result[3].how.endswith("; a point")
    assert [item.what for item in result] == ["body box", "body mover", "body ship", "body buoy"]


def test_a_resting_body_without_echoes_is_never_visible_a_moving_one_may_be_later() -> None:
    result = items(per_body([100, 1, 50, 1], [0, 1, 0, 1]))
    assert (result[0].modelled, result[0].how, result[0].power_db) == (False, NEVER_VISIBLE, 0.0)
    assert result[2].modelled


def test_a_culled_body_has_its_reason_its_error_and_its_shadow() -> None:
    culled = {0: CulledBody("too weak", 0.1, occludes=True), 3: CulledBody("too far", 0.0, occludes=False)}
    result = items(EngineStatistics(culled))
    assert (result[0].modelled, result[0].how, result[0].power_db) == (
        False,
        "too weak; still occludes what is behind it",
        0.1,
    )
    assert (result[3].modelled, result[3].how, result[3].power_db) == (False, "too far", 0.0)
    assert result[1].modelled and result[1].microseconds is None


def test_the_documented_engine_counts_triangles() -> None:
    mesh = made().bodies[0].mesh
    assert mesh is not None
    triangles = len(mesh.faces)
    assert [item.how for item in items(EngineStatistics(), "documented")] == [
        f"rays against {triangles} triangles",
        "one hit per azimuth",
        f"rays against {triangles} triangles",
        "one hit per azimuth",
    ]
