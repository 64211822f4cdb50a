"""What `check` says of bodies over the run."""

import radar_service as rs
from radar_service.plan.remarks import body_remarks
from radar_service.records.fidelity import PRESETS
from tests.plan.scenes import SHIP, made
from tests.scenes import point


def remarks(scene: rs.Scene, name: str) -> list[str]:
    return body_remarks(scene, PRESETS["balanced"])[name]


def test_the_closest_approach_is_stated_with_rates_where_anything_moves() -> None:
    """10 kn past at 300 m, abeam after 500 m: 97 s; 5.144 m/s over 300 m is 0.98 degrees/s. Rates are those within range."""
    world = made([point("t", 300, 500, speed_kn=10, course_deg=180)])
    assert remarks(world, "t") == ["nearest after 97 s: 300 m; its aspect turns by up to 0.98 degrees/s, its range by 5 m/s"]
    assert remarks(made([point("t", 300, 500)]), "t") == []


def test_what_is_steered_is_judged_beside_the_antenna() -> None:
    (remark,) = remarks(made([point("t", 300, 500, steerable={"max_speed_kn": 10, "max_turn_rate_deg_s": 2})]), "t")
    assert remark.startswith("commands may bring it anywhere") and "by up to 39 degrees/s, its range by 5.1 m/s" in remark


def test_metal_is_judged_at_the_closest_approach_and_others_by_their_errors() -> None:
    metal = SHIP | {"scattering": "optics", "position_m": [40, 1400, 0], "speed_kn": 20, "course_deg": 180}
    assert any("optics: facets" in remark and "cut to 0." in remark for remark in remarks(made([metal]), "ship"))
    declared = made([metal | {"scattering": "rcs", "rcs_dbsm": 30}])
    assert any("its phases change at each visibility step" in remark for remark in remarks(declared, "ship"))


def test_loops_that_never_repeat_say_how_long_they_are_followed() -> None:
    loop = {
        "loop": True,
        "waypoints": [{"position_m": [600, 500], "speed_kn": 9}, {"position_m": [600, 700], "speed_kn": 9}],
    }
    world = made([point("t", 500, 500) | loop], own_ship={"speed_kn": 1, "course_deg": 90})
    assert remarks(world, "t")[0].endswith("its loops are followed for 3600 s")
