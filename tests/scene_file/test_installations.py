"""Where several radars reach, and sentences about one of them."""

import math
from typing import Any

import numpy as np
import pytest

from radar_service.scene_file.installations import at_location, located, reach
from radar_service.scene_file.load import load_scene
from radar_service.world.error import SceneError
from radar_service.world.motion import Motion
from radar_service.world.platform import Platform
from tests.scenes import point, radar

AT_PISA: dict[str, Any] = {"latitude_deg": 43.7, "longitude_deg": 10.4}


def platform(*positions: tuple[float, float], speed: float = 0.0) -> Platform:
    knots = np.array([[*position, 0.0] for position in positions])
    time = np.arange(len(knots), dtype=np.float64)
    return Platform(Motion(time, knots, np.zeros(len(knots)), np.array([speed, 0.0, 0.0])))


def test_the_circle_encloses_what_each_radar_reaches() -> None:
    """The second stands 5 km from the first and travels 1 km: 5 + 2 + 1."""
    near, far = radar(range_max_m=1000), radar(range_max_m=2000)
    both = reach([near, far], [platform((0, 0)), platform((3000, 4000), (3000, 5000))])
    assert tuple(both) == (0.0, 0.0, 8000.0)
    assert tuple(reach([near], [platform((7, 8))])) == (7.0, 8.0, 1000.0)
    assert tuple(reach([near], [None])) == (0.0, 0.0, 1000.0)  # one that could not be read
    assert reach([near, far], [platform((0, 0)), platform((0, 0), speed=1.0)]).radius == math.inf


def test_a_sentence_names_the_radar_that_it_is_about() -> None:
    assert located("radar.pulse_s: too long", "radar[2]") == "radar[2].pulse_s: too long"
    assert located("radar.pulse_s: too long", "radar") == "radar.pulse_s: too long"
    assert located("body[0]: below the sea", "radar[2]") == "body[0]: below the sea"
    with pytest.raises(SceneError) as refused, at_location("radar[1]"):
        raise SceneError("radar.rpm: no", "body: no")
    assert refused.value.problems == ("radar[1].rpm: no", "body: no")


def test_warnings_name_the_platform_and_come_once() -> None:
    site = {"platform": {"position_m": [300_000, 0]}}
    made = load_scene(
        {
            "origin": AT_PISA,
            "radar": [{"id": "a", **site}, {"id": "b", "pulse_s": 1e-6, "bandwidth_hz": 5e6, "sample_rate_hz": 5e6}],
            "body": [point("deep", 0, 50, -9.0)],
        }
    )
    far, deep, folding = made.warnings
    assert far.startswith("radar[0].platform: at 300 km from the origin the map is stretched by")
    assert folding.startswith("radar[1].sample_rate_hz: with bandwidth x pulse 5")
    assert deep.startswith("body[0]: deep is entirely below the sea")
    assert made.for_radar("b").warnings == made.warnings
