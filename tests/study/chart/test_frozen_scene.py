"""Frozen scenes and their echoes."""

import numpy as np
import pytest

from radar_service.records.fidelity import PRESETS
from radar_service.study.chart.frozen_scene import all_echoes, all_scatterers, frozen, is_diffuse, only_diffuse
from tests.scenes import point, scene
from tests.study.chart.settings import PLATE, SMALL

SHIP = point("ship", 300, 400, speed_kn=20, course_deg=90, swerling=1)


def test_a_frozen_scene_keeps_the_poses_of_the_start() -> None:
    moving = scene([SHIP], radar={**SMALL, "blind_sectors_deg": [[10, 20]]}, own_ship={"speed_kn": 10, "course_deg": 45})
    start = frozen(moving)
    (body,) = start.bodies
    assert body.motion.at_rest and start.own_ship.at_rest and body.swerling == 0
    assert start.radar.blind_sectors == () and not start.radar.eclipsing
    np.testing.assert_array_equal(body.motion.pose(99.0).position, moving.bodies[0].motion.pose(0.0).position)
    np.testing.assert_array_equal(start.antenna(99.0), moving.antenna(0.0))
    assert start.own_ship.pose(0.0).heading == moving.own_ship.pose(0.0).heading


def test_echoes_end_where_their_sidelobes_no_longer_reach_a_bin() -> None:
    """cT/2 of a pulse of 4 us is 600 m, so echoes end at 2100 m of a range of 1500 m."""
    near, far = point("near", 0, 2095), point("far", 0, 2105)
    echoes = all_echoes(frozen(scene([near, far], radar=SMALL)), 0)
    assert echoes.range == pytest.approx([2095.0], abs=1.0) and echoes.azimuth == pytest.approx([0.0])


def test_only_diffuse_surfaces_remain() -> None:
    world = only_diffuse(scene([PLATE, SHIP], radar=SMALL, environment={"multipath": True, "noise": True}))
    assert [body.name for body in world.bodies] == ["p"] and is_diffuse(world.bodies[0])
    assert not world.environment.multipath and not world.environment.noise


def test_scatterers_follow_the_fidelity() -> None:
    """Sixteen to a cell are four times those of four to a cell, within 5 % of rounding to whole points."""
    plate = frozen(scene([{**PLATE, "width_m": 1000, "height_m": 300}], radar=SMALL))
    some, more = (int(all_scatterers(plate, PRESETS[name], 0).scatterers.sum()) for name in ("balanced", "reference"))
    assert more == pytest.approx(4 * some, rel=0.05)
