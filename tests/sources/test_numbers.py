"""Numbers and names of sources."""

from radar_service.echo.echoes import SECOND_TIME
from radar_service.sources.numbers import BODY, source_names, source_numbers
from radar_service.stages.registry import numbers_of
from radar_service.world.materials import MATERIALS, is_land
from tests.scenes import point, scene

BOX = {"shape": "box", "length_m": 20, "width_m": 30, "height_m": 8}


def test_land_is_one_source_for_each_material_and_every_other_body_one_of_its_own() -> None:
    bodies = [
        {**BOX, "name": "quay", "position_m": [0, 500, 0], "material": "concrete"},
        {**BOX, "name": "ferry", "position_m": [0, 300, 0], "material": "steel"},
        {**BOX, "name": "pier", "position_m": [0, 700, 0], "material": "concrete"},
        {**BOX, "name": "floe", "position_m": [0, 900, 0], "material": "ice", "speed_kn": 1},
        point("stone", 500, 0, material="rock"),
    ]
    made = scene(bodies)
    assert [is_land(body) for body in made.bodies] == [True, False, True, False, False]
    assert source_numbers(made).tolist() == [20, BODY + 1, 20, BODY + 3, BODY + 4, 4]
    assert source_names(made) == {
        0: "noise", 1: "sea", 2: "rain", 3: "interference", 4: "second time around",
        9: "range sidelobes and faint parts", 20: "land: concrete",
        257: "ferry", 259: "floe", 260: "stone",
    }  # fmt: skip


def test_numbers_of_land_stay_below_those_of_bodies() -> None:
    assert 16 + len(MATERIALS) <= BODY


def test_answers_of_beacons_are_sources_of_their_own() -> None:
    """Scenes without beacons have no such names."""
    made = scene([point("tower", 0, 500, racon={"letter": "K"}), point("raft", 500, 0, sart={})])
    assert (source_names(made)[5], source_names(made)[6]) == ("racon", "sart")
    assert source_names(scene([point("raft", 500, 0, sart={})])).keys() == {0, 1, 2, 3, 4, 6, 9, 256}


def test_faint_parts_are_named_where_bodies_have_any() -> None:
    quay = {**BOX, "name": "quay", "position_m": [0, 500, 0], "material": "concrete"}
    assert 9 not in source_names(scene([quay]))
    assert 9 not in source_names(scene([point("p", 0, 500)], radar={"labels_within_db": "none"}))


def test_false_echoes_are_sources_of_their_own_where_a_scene_has_any() -> None:
    """Behind the bodies, in the order of effects; without them nothing changes."""
    structure = [{"bearing_deg": 0, "distance_m": 3, "width_m": 0.2}]
    radar = {"structure": structure, "multiple_echoes": {"own_rcs_dbsm": 30}}
    made = scene([point("p", 0, 500)], radar=radar)
    assert source_numbers(made).tolist() == [256, 7, 8, 4] and source_numbers(made)[SECOND_TIME] == 4
    assert (numbers_of(made, "structures"), numbers_of(made, "multiple")) == (
        ({"indirect": 7}, {"indirect": 1}), ({"multiple": 8}, {"multiple": 2})
    )  # fmt: skip
    assert (source_names(made)[7], source_names(made)[8]) == ("indirect", "multiple")
    only = scene([point("p", 0, 500)], radar={"multiple_echoes": {"own_rcs_dbsm": 30}})
    assert source_numbers(only).tolist() == [256, 8, 4] and 7 not in source_names(only)
    assert source_numbers(scene([point("p", 0, 500)])).tolist() == [256, 4]
