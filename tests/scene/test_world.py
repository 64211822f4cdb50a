"""A scene is a world, a radar and a platform."""

import numpy as np

from radar_service.scene.world import World
from tests.scenes import point, scene


def test_a_scene_gives_the_parts_of_its_world_and_platform() -> None:
    made = scene([point("a", 1, 2)], own_ship={"position_m": [5, 6]}, origin={"latitude_deg": 1.0, "longitude_deg": 2.0})
    assert made.world == World("test", (1.0, 2.0), made.environment, made.bodies)
    assert (made.name, made.origin) == ("test", (1.0, 2.0))
    assert made.own_ship is made.platform.motion
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
