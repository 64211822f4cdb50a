"""What a service knows of a scene."""

import pickle

from radar_service.scene_file.load import load_scene
from radar_service.world.outline import outline_of

BUOY = {"name": "buoy", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 100, 5], "steerable": {}}


def test_an_outline_says_what_may_be_steered_and_holds_no_bodies() -> None:
    scene = load_scene({"name": "harbour", "origin": {"latitude_deg": 50, "longitude_deg": 1}, "body": [BUOY] * 1})
    outline = outline_of(scene)
    assert (outline.name, outline.origin, outline.body_count) == ("harbour", (50, 1), 1)
    assert outline.radar is scene.radar and outline.steerable.names == {"buoy"} and outline.has_sensors
    assert pickle.loads(pickle.dumps(outline)) == outline
