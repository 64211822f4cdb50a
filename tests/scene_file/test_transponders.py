"""AIS transponders of a scene file."""

import math
from typing import Any

import pytest

from radar_service.scene_file.load import load_scene
from radar_service.world.reporting import Ais, AisSettings, AisShip
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


def test_a_kind_is_a_ship_unless_it_is_told() -> None:
    assert (ship().kind, ship().aid_type) == ("ship", 0)
    made = ship(ais={"kind": "aid", "aid_type": 24})
    assert (made.kind, made.aid_type, ship(ais={"kind": "sart"}).kind) == ("aid", 24, "sart")


@pytest.mark.parametrize(
    ("mmsi", "kind", "words"),
    [
        (235000001, "ship", ()), (775999999, "ship", ()), (992350001, "aid", ()), (970010001, "sart", ()),
        (2350000, "ship", ("body[1].mmsi: 002350000 is not the number of a ship", "; give one like 235000001")),
        (970010001, "ship", ("970010001 is not the number of a ship", 'set ais.kind = "sart", or give one like 235000001')),
        (992350001, "ship", ('set ais.kind = "aid", or give',)), (111235001, "ship", ("111235001",)),
        (235000001, "aid", ("an aid to navigation", '"ship"')), (982350001, "ship", ("a ship",)),
        (999000001, "ship", ("999000001",)), (974010001, "sart", ("a SART", "; give one like 970010001")),
    ],
)  # fmt: skip
def test_a_number_of_another_kind_is_warned_of(mmsi: int, kind: str, words: tuple[str, ...]) -> None:
    scene = load_scene({"body": [point("p", position_m=[50, 0, 0]), {**SHIP, "mmsi": mmsi, "ais": {"kind": kind}}]})
    told = [warning for warning in scene.warnings if "is not the number of" in warning]
    assert len(told) == bool(words) and all(word in told[0] for word in words)


def test_own_ship_is_warned_of_and_shipped_scenes_are_not() -> None:
    """Their numbers have the country code 299, which belongs to nobody, so that no ship is taken for one that exists."""
    (warning,) = load_scene({"own_ship": {"mmsi": 9}}).warnings
    assert warning.startswith("own_ship.mmsi: 000000009 is not the number of a ship")
    numbers = [made.mmsi for name in ("harbour", "open-sea") for made in load_scene(name).ais.ships]
    assert len(numbers) == 12 and {number // 10**6 for number in numbers} == {299}
    assert not [warning for name in ("harbour", "open-sea") for warning in load_scene(name).warnings if "mmsi" in warning]


def test_own_ship_and_the_settings() -> None:
    scene = load_scene({"own_ship": {"mmsi": 9, "ais": {"length_m": 30, "beam_m": 8}, "draught_m": 2}, "body": [SHIP],
                        "ais": {"latency_s": 2, "loss_percent": 25, "position_error_m": 12}})  # fmt: skip
    assert [made.mmsi for made in scene.ais.ships] == [9, 7] and scene.ais.ships[0].body is None
    assert (scene.ais.ships[0].to_bow, scene.ais.ships[0].draught) == (15.0, 2.0)
    assert scene.ais.settings == AisSettings(2.0, 0.25, 12.0)
