"""The radars of a scene file: ids, platforms, and what is refused."""

from typing import Any

import pytest

from radar_service.scene_file.load import load_scene, model_from
from radar_service.scene_file.model.platform import MAX_RADARS, radar_entries
from tests.scene_file.scene_sources import point, problems

SITE = {"id": "shore", "platform": {"position_m": [500, -20], "heading_deg": 90}}
ISLAND = {"name": "island", "heightmap": "h.npy", "low_m": 0, "high_m": 9, "extent_m": [100, 100]}


def test_a_single_radar_has_the_id_0_and_stands_on_own_ship() -> None:
    (entry,) = radar_entries(model_from({"radar": {"rpm": 30}}).radar)
    assert (entry.id, entry.location, entry.model.rpm, entry.platform) == ("0", "radar", 30, None)


def test_radars_keep_the_order_of_the_file() -> None:
    first, second = radar_entries(model_from({"radar": [{"id": "bow-1", "rpm": 30}, SITE]}).radar)
    assert (first.id, first.location, first.model.rpm, first.platform) == ("bow-1", "radar[0]", 30, None)
    assert (second.id, second.location, second.model.rpm) == ("shore", "radar[1]", 24)
    assert second.platform is not None and second.platform.position_m == (500, -20)


# What the list of radars, own ship and the bodies are, and how the only problem begins.
REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"radar": []}, f"radar: [] is not allowed; a list of 1 to {MAX_RADARS} radars: add one, or remove the list"),
    ({"radar": [{"id": str(i)} for i in range(MAX_RADARS + 1)]}, f"radar: a list of {MAX_RADARS + 1} values is not allowed"),
    ({"radar": "bow"}, 'radar: "bow" is not allowed; a table with the keys modulation'),
    ({"radar": [5]}, "radar[0]: 5 is not allowed; a table with the keys modulation"),
    ({"radar": [{"rpm": 24}]}, "radar[0].id: missing; text of 1 to 32 characters: letters, digits, - and _"),
    ({"radar": [{"id": "a/b"}]}, 'radar[0].id: "a/b" is not allowed; text of 1 to 32 characters: letters, digits, - and _'),
    ({"radar": [{"id": "bow\n"}]}, r'radar[0].id: "bow\n" is not allowed'),
    ({"radar": [{"id": ".."}]}, 'radar[0].id: ".." is not allowed'),
    ({"radar": [{"id": ""}]}, 'radar[0].id: "" is not allowed; text of 1 to 32 characters'),
    ({"radar": [{"id": "a" * 33}]}, f'radar[0].id: "{"a" * 33}" is not allowed'),
    ({"radar": [{"id": 7}]}, "radar[0].id: 7 is not allowed; text of 1 to 32 characters"),
    ({"radar": [{"id": "a"}, {"id": "b"}, {"id": "a"}]}, 'radar[2].id: "a" is taken by an earlier radar; ids are unique'),
    ({"radar": [{"id": "a"}, {"id": "b", "rpm": -1}]}, "radar[1].rpm: -1 is not allowed; a finite number from 0.01 to 600"),
    ({"radar": [{"id": "a", "rmp": 1}]}, 'radar[0].rmp: this is not a known key; did you mean "rpm"?'),
    ({"radar": [{"id": "a", "plattform": {}}]}, 'radar[0].plattform: this is not a known key; did you mean "platform"?'),
    ({"radar": {"rmp": 1}}, 'radar.rmp: this is not a known key; did you mean "rpm"?'),
    ({"radar": {"id": "a"}}, "radar.id: this is not a known key; remove it"),
    ({"radar": [{"id": "a", "platform": {}}]}, "radar[0].platform.body: a platform has exactly one of body, position_m"),
    ({"radar": [{"id": "a", "platform": "p"}]}, 'radar[0].platform: "p" is not allowed; a table with the keys body'),
    (
        {"radar": [{"id": "a", "platform": {"body": "p", "position_m": [1, 2]}}], "body": [point("p")]},
        "radar[0].platform.body: a platform has exactly one of body, position_m, and latitude_deg with longitude_deg; this "
        "one has body and position_m",
    ),
    ({"radar": [{"id": "a", "platform": {"body": "p", "heading_deg": 3}}], "body": [point("p")]},
     "radar[0].platform.heading_deg: the body already defines the heading; remove heading_deg"),
    ({"radar": [{"id": "a", "platform": {"body": "q"}}], "body": [point("p"), ISLAND]},
     'radar[0].platform.body: "q" is not a body of this scene; it has p: correct the name or add the body'),
    ({"own_ship": {"body": "q"}}, 'own_ship.body: "q" is not a body of this scene; it has no body that could carry'),
    ({"own_ship": {"body": "island"}, "body": [ISLAND]},
     'own_ship.body: "island" is a height map, which carries no antenna; give a site by position_m'),
    ({"own_ship": {"body": "p", "speed_kn": 3, "roll_deg": 2}, "body": [point("p")]},
     "own_ship.roll_deg: the body already defines how own ship moves; remove roll_deg, speed_kn"),
    ({"radar": [{"id": "a", "platform": {"latitude_deg": 3}}]},
     "radar[0].platform.latitude_deg: this key needs latitude_deg and longitude_deg together"),
    ({"radar": [{"id": "a", "platform": {"latitude_deg": 3, "longitude_deg": 4}}]},
     "radar[0].platform.latitude_deg: latitude and longitude need an [origin] in the scene; add one"),
]  # fmt: skip


@pytest.mark.parametrize(("data", "message"), REFUSED)
def test_bad_radars_are_refused_with_one_line(data: dict[str, Any], message: str) -> None:
    (line,) = problems(data)
    assert line.startswith(message)


def test_every_problem_of_a_list_is_named() -> None:
    lines = problems({"radar": [{"id": "a", "rpm": -1}, {"id": "b", "azimuths": 1}]})
    assert [line.split(":")[0] for line in lines] == ["radar[0].rpm", "radar[1].azimuths"]


def test_a_message_names_few_of_many_bodies() -> None:
    (line,) = problems({"own_ship": {"body": "x"}, "body": [point(f"b{i}") for i in range(9)]})
    assert "it has b0, b1, b2, b3, b4, b5 and 3 more" in line


def test_a_site_in_degrees() -> None:
    """A tenth of a degree north of the origin is 11.06 km on the ellipsoid at the equator (6335.4 km of radius)."""
    made = load_scene(
        {
            "origin": {"latitude_deg": 0, "longitude_deg": 0},
            "radar": [{"id": "light", "height_m": 40, "platform": {"latitude_deg": 0.1, "longitude_deg": 0}}],
        }
    )
    (antenna,) = made.antenna(7.0).tolist()
    assert antenna == pytest.approx([0, 11_057.4, 40], abs=0.1)  # the last printed digit
    assert made.own_ship.at_rest
