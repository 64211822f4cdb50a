"""The scene at another rate of rotation, and from another origin on."""

import pytest

import radar_service as rs
from radar_service.radar.parameters import Origin, max_rpm
from radar_service.world.rotation import scene_at_origin, scene_at_rpm


def test_spokes_come_at_the_other_rate_from_the_origin_on() -> None:
    scene = rs.load_scene({"radar": {"azimuths": 360, "rpm": 24}})
    faster = scene_at_rpm(scene, 48, Origin(7.5, 1080))
    assert faster.radar.rotation_period == 1.25 and faster.radar.origin == Origin(7.5, 1080)
    assert scene_at_origin(scene, Origin(7.5, 1080)).radar.rotation_period == 2.5 == scene.radar.rotation_period


def test_each_spoke_has_a_pulse_of_its_own() -> None:
    scene = rs.load_scene({"radar": {"azimuths": 360, "rpm": 24, "prf_hz": 300, "pulse_s": 1e-6}})
    assert max_rpm(300, 360) == pytest.approx(50.0, rel=1e-8)  # 300 pulses for 360 spokes: 0.8333 revolutions a second
    assert scene_at_rpm(scene, 50).radar.rotation_period == pytest.approx(1.2)
    with pytest.raises(rs.SceneError, match=r"rpm: 51 gives 306 spokes a second, more than the 300 pulses.*at most 50"):
        scene_at_rpm(scene, 51)
