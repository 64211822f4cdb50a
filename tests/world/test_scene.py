"""A scene is a world, a radar and a platform."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.random import name_key
from radar_service.radar.parameters import max_rpm
from radar_service.world.scene import Scene, World, scene_at_rpm
from tests.scenes import point, scene


def test_a_scene_gives_the_parts_of_its_world_and_platform() -> None:
    made = scene([point("a", 1, 2)], own_ship={"position_m": [5, 6]}, origin={"latitude_deg": 1.0, "longitude_deg": 2.0})
    assert made.world == World("test", (1.0, 2.0), made.environment, made.bodies)
    assert (made.name, made.origin) == ("test", (1.0, 2.0))
    assert made.own_ship is made.platform.motion
    six, seven = (repr(scene([point(f"b{k}", k, 9) for k in range(count)])) for count in (6, 7))
    assert "more" not in six and "b5 and 1 more" in seven
    np.testing.assert_array_equal(made.antenna(0.0), [[5.0, 6.0, made.radar.height]])


def test_with_world_changes_the_world_only() -> None:
    made = scene([point("a", 1, 2), point("b", 3, 4)])
    changed = made.with_world(bodies=made.bodies[1:])
    assert [body.name for body in changed.bodies] == ["b"] and len(made.bodies) == 2
    assert changed.environment is made.environment
    assert changed.radar is made.radar and changed.platform is made.platform


def test_blind_sectors_turn_with_the_platform() -> None:
    """A sector of 80 to 100 degrees from the bow, on a heading of 90: 170 to 190 degrees from north."""
    made = scene(radar={"blind_sectors_deg": [[80, 100]]}, own_ship={"heading_deg": 90})
    boresight = np.deg2rad([90.0, 165.0, 180.0, 195.0])
    assert made.blind(np.zeros(4), boresight).tolist() == [False, False, True, False]


def several(**sections: Any) -> Scene:
    """Own ship is the tug; one radar on it, one on a pier, one on the ferry."""
    radars = [
        {"id": "bow", "frequency_hz": 3.05e9},
        {"id": "pier", "rpm": 48, "platform": {"position_m": [500, 0], "heading_deg": 90}},
        {"id": "ferry-1", "platform": {"body": "ferry"}},
    ]
    bodies = [point("tug", 0, 0, 2, speed_kn=10), point("ferry", 0, 900, 2, course_deg=90, speed_kn=20), point("buoy", 9, 9)]
    return scene(bodies, **{"radar": radars, "own_ship": {"body": "tug"}} | sections)


def test_a_scene_is_that_of_its_first_radar() -> None:
    made = several()
    assert [its.id for its in made.radars] == ["bow", "pier", "ferry-1"]
    assert (made.radar_id, made.radar, made.platform) == ("bow", made.radars[0].radar, made.radars[0].platform)
    assert made.for_radar("bow") is made
    assert (scene().radar_id, [its.id for its in scene().radars]) == ("0", ["0"])


def test_each_radar_has_its_platform_and_sees_all_other_bodies() -> None:
    made = several()
    bow, pier, ferry = (made.for_radar(name) for name in ("bow", "pier", "ferry-1"))
    assert [[body.name for body in its.bodies] for its in (bow, pier, ferry)] == [
        ["ferry", "buoy"], ["tug", "ferry", "buoy"], ["tug", "buoy"],
    ]  # fmt: skip
    assert [its.platform.body for its in (bow, pier, ferry)] == ["tug", None, "ferry"]
    assert bow.own_ship is pier.bodies[0].motion and ferry.own_ship is pier.bodies[1].motion
    assert bow.world.bodies == pier.world.bodies and pier.body_count == 3
    np.testing.assert_array_equal(pier.antenna(99.0), [[500, 0, 15]])
    assert pier.platform.heading(np.zeros(1)) == np.pi / 2
    assert (pier.radar.rotation_period, pier.for_radar("bow").radar) == (1.25, bow.radar)
    assert pier.for_radar("ferry-1").own_ship is ferry.own_ship


def test_gas_attenuates_each_radar_at_its_own_frequency() -> None:
    """At 9.4 GHz more than at 3 GHz: ITU-R P.676, figure 5."""
    made = several(environment={"gas_db_per_km": "itu"})
    low, high = (made.for_radar(name).environment.gas_db_per_km for name in ("bow", "pier"))
    assert 0.0 < low < high


def test_an_unknown_radar_is_refused_with_those_there_are() -> None:
    with pytest.raises(ValueError, match='radar: "stern" is not a radar of this scene; it has bow, pier, ferry-1: give one'):
        several().for_radar("stern")
    with pytest.raises(ValueError, match='"1" is not a radar of this scene; it has 0'):
        scene().for_radar("1")


def test_only_an_id_of_its_own_keys_random_numbers() -> None:
    assert several().random_key == (name_key("bow"),)
    assert scene(radar=[{"id": "0"}]).random_key == scene().random_key == ()
    assert (several().own_id, scene().own_id) == ("bow", "")


def test_each_spoke_has_a_pulse_of_its_own() -> None:
    scene = rs.load_scene({"radar": {"azimuths": 360, "rpm": 24, "prf_hz": 300, "pulse_s": 1e-6}})
    assert max_rpm(300, 360) == pytest.approx(50.0, rel=1e-8)  # 300 pulses for 360 spokes: 0.8333 revolutions a second
    assert scene_at_rpm(scene, 50).radar.rotation_period == pytest.approx(1.2)
    with pytest.raises(rs.SceneError, match=r"rpm: 51 gives 306 spokes a second, more than the 300 pulses.*at most 50"):
        scene_at_rpm(scene, 51)
