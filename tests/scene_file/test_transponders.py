"""AIS transponders of a scene file."""

import math
from typing import Any

from radar_service.scene_file.load import load_scene
from radar_service.world.ais import Ais, AisSettings, AisShip
from tests.scene_file.scene_sources import point

SHIP = {
    "name": "a b",
    "shape": "hull",
    "length_m": 80.0,
    "beam_m": 12.0,
    "height_m": 9.0,
    "position_m": [900, 0, -3],
    "mmsi": 7,
}


def ship(**keys: Any) -> AisShip:
    (made,) = load_scene({"body": [{**SHIP, **keys}]}).ais.ships
    return made


def test_a_number_makes_a_transponder_with_the_body_as_it_is() -> None:
    made = ship()
    assert (made.body, made.mmsi, made.station_class, made.name, made.draught) == ("a b", 7, "A", "A B", 3.0)
    assert (made.to_bow, made.to_stern, made.to_port, made.to_starboard) == (40.0, 40.0, 6.0, 6.0)
    assert load_scene({"body": [point("p")]}).ais == Ais()


def test_keys_say_more() -> None:
    made = ship(
        ais={"class": "B-SO", "name": "x", "antenna_m": [2, -10], "off_s": [[1, 2.5]], "heading_error_deg": 180},
        draught_m=4.5,
    )
    assert (made.station_class, made.name, made.draught, made.heading_error) == ("B-SO", "X", 4.5, math.pi)
    assert (made.to_bow, made.to_stern, made.to_port, made.to_starboard) == (50.0, 30.0, 8.0, 4.0)
    assert made.antenna == (2.0, -10.0)
    assert made.silent == ((1.0, 2.5),)


def test_own_ship_and_the_settings() -> None:
    scene = load_scene({"own_ship": {"mmsi": 9, "ais": {"length_m": 30, "beam_m": 8}, "draught_m": 2}, "body": [SHIP],
                        "ais": {"latency_s": 2, "loss_percent": 25, "position_error_m": 12}})  # fmt: skip
    assert [made.mmsi for made in scene.ais.ships] == [9, 7] and scene.ais.ships[0].body is None
    assert (scene.ais.ships[0].to_bow, scene.ais.ships[0].draught) == (15.0, 2.0)
    assert scene.ais.settings == AisSettings(2.0, 0.25, 12.0)
