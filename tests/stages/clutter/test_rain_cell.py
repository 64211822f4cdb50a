"""Rain cells: their edges against brute force, what they add and take against uniform rain and closed forms, bad input."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.propagation.gas_and_rain import rain_db_per_km
from radar_service.sources.numbers import BODY
from radar_service.stages.clutter.effect import RAIN, RAIN_CELL, RainCells
from radar_service.world.error import SceneError
from tests.scenes import point, scene

RADAR = {"range_max_m": 6000, "azimuths": 360, "beamwidth_deg": 2}
FEW = {"azimuths": 90, "beamwidth_deg": 8}
HOOK = [[-2000, 500], [2000, 500], [2000, 2500], [1000, 2500], [1000, 1500], [-1000, 1500], [-1000, 2500], [-2000, 2500]]
EVERYWHERE = {"position_m": [0, 0], "radius_m": 1e6}


def wet(bodies: Any = (), radar: Any = None, own_ship: Any = None, **environment: Any) -> rs.Scene:
    """A scene with rain."""
    return scene(list(bodies), radar=RADAR | (radar or {}), own_ship=own_ship or {}, environment=environment)


def cells_of(*tables: dict[str, Any]) -> RainCells:
    """The cells of tables."""
    cells = wet(rain_cell=[{"rain_mm_h": 20.0} | table for table in tables]).environment.effect_keys[RAIN_CELL]
    assert isinstance(cells, RainCells)
    return cells


@pytest.mark.parametrize("antenna", [(0.0, 0.0), (0.0, 1000.0), (1500.0, 2000.0), (-300.0, 4000.0)])
@pytest.mark.parametrize(
    "table", [{"outline_m": HOOK}, {"outline_m": HOOK[::-1]}, {"position_m": [0, 1500], "radius_m": 1200}]
)
def test_paths_are_those_of_points_inside(table: dict[str, Any], antenna: tuple[float, float]) -> None:
    """From outside, inside and in the hollow, all round: points 1 m apart, of which each edge may cost half a metre."""
    azimuth, reach, course = np.deg2rad(np.arange(0.5, 360.0, 7.0)), 5000.0, 40.0 * np.array([np.sin(0.7), np.cos(0.7)])
    cells = cells_of(table | {"course_deg": np.rad2deg(0.7), "speed_kn": 40 * 3600 / 1852})
    found, expected = np.zeros((len(azimuth), 2)), np.zeros((len(azimuth), 2))
    for _, rows, inside in cells.paths(np.array([*antenna, 9.0]), 10.0, azimuth, np.array([[2000.0, reach]])):
        found[rows] += inside
    along = np.arange(0.5, reach)
    for k, angle in enumerate(azimuth):
        points = np.array(antenna) + along[:, None] * [np.sin(angle), np.cos(angle)] - course * 10.0
        east, north = points.T
        if "radius_m" in table:
            inside = np.hypot(east, north - 1500) < 1200
        else:
            box = (np.abs(east) < 2000) & (north > 500) & (north < 2500)
            inside = box & ~((np.abs(east) < 1000) & (north > 1500))
        expected[k] = inside[:2000].sum(), inside.sum()
    np.testing.assert_allclose(found, expected, atol=2.0)


@pytest.mark.sample(2)
@pytest.mark.parametrize("table", [EVERYWHERE, {"outline_m": [[-9e4, -9e4], [-9e4, 9e4], [9e4, 9e4], [9e4, -9e4]]}])
@pytest.mark.parametrize("environment", [{}, {"sea_state": 4, "noise": True}], ids=["rain", "sea"])
def test_a_cell_everywhere_is_uniform_rain(table: dict[str, Any], environment: dict[str, Any]) -> None:
    bodies, own_ship = [point("buoy", 3000, 1000, rcs_dbsm=30)], {"speed_kn": 10, "course_deg": 90}
    uniform, cell = (
        rs.Simulator(wet(bodies, FEW, own_ship, **environment, **rain), "fast", seed=4).scan().field
        for rain in ({"rain_mm_h": 20.0}, {"rain_cell": [table | {"rain_mm_h": 20.0}]})
    )
    np.testing.assert_allclose(cell, uniform, atol=2e-6 * np.abs(uniform).max())


def test_a_cell_has_the_power_of_rain_where_it_is_and_moves() -> None:
    """1 km of rain, 2 to 3 km off: its mean power by the radar equation for a volume, and only sidelobes of the pulse
    beyond its edges; an hour later at 20 kn it has left, and another has come."""
    square, away = [[-4e4, 2000], [-4e4, 3000], [4e4, 3000], [4e4, 2000]], 20.0 * 1852
    moving = {"speed_kn": 20, "course_deg": 0, "rain_mm_h": 40.0}
    coming = [[east, north - away] for east, north in square]
    made = wet(rain_cell=[moving | {"outline_m": square}, moving | {"outline_m": coming}])
    uniform = rs.Simulator(wet(rain_mm_h=40.0), "fast", seed=1).scan().power[:40]
    sim = rs.Simulator(made, "fast", seed=1, labels=True)
    scan, kept = sim.scan(), slice(0, 10)
    lost_db = 2.0 * rain_db_per_km(40.0, "h", made.radar.frequency) * 2.0  # uniform rain up to 2 km, two ways
    cell = np.flatnonzero((scan.range > 2030) & (scan.range < 2970))
    ratio = 10 * np.log10(scan.power[kept, cell] / uniform[kept, cell])
    np.testing.assert_allclose(ratio, lost_db, atol=0.15)  # cos(9 degrees) of the way to the edge
    assert scan.power[kept][:, (scan.range < 1900) | (scan.range > 3150)].max(initial=0.0) < 1e-3 * scan.power[kept].max()
    assert scan.labels is not None and (scan.labels[kept, cell] == RAIN).all()
    turns = round(3600.0 / made.radar.rotation_period)
    sim.skip_to(turns)
    late = sim.scan()
    moved = 20.0 * 1852 / 3600 * (turns * made.radar.rotation_period - 3600.0)
    inside = late.power[kept][:, (late.range > 2050 + moved) & (late.range < 2950 + moved)]
    assert inside.mean() > 0.3 * scan.power[kept, cell].mean()
    (first, second) = sim.snapshot(turns).effects["clutter"]["rain_cells"]
    assert second["rain_mm_h"] == 40.0 and abs(first["outline"][0][1] - second["outline"][0][1] - away) < 1e-6


@pytest.mark.parametrize("own_ship", [{}, {"speed_kn": 20, "course_deg": 0}], ids=["at rest", "under way"])
def test_an_echo_behind_a_cell_is_weaker_by_its_way_through_it(own_ship: dict[str, Any]) -> None:
    """ITU-R P.838 over the 1 km of rain before a buoy, and none of it before the one beside the cell."""
    bodies = [point("behind", 0, 5000, rcs_dbsm=40), point("beside", 4000, 0, rcs_dbsm=40)]
    cell = {"outline_m": [[-500, 2000], [-500, 3000], [500, 3000], [500, 2000]], "rain_mm_h": 100.0}
    dry, rain = (
        rs.Simulator(wet(bodies, own_ship=own_ship, **given), "fast").scan().power for given in ({}, {"rain_cell": [cell]})
    )
    behind, beside = (10 * np.log10(dry[k].max() / rain[k, dry[k].argmax()]) for k in (0, 90))
    np.testing.assert_allclose([behind, beside], [2.0 * rain_db_per_km(100.0, "h", 9.41e9), 0.0], atol=0.02)


@pytest.mark.parametrize(("radar", "rcs"), [({}, -15), ({"power_w": 1e-5}, 58)], ids=["rain seen", "rain below noise"])
def test_labels_and_sources_of_what_rests_lose_what_its_echoes_do(radar: dict[str, float], rcs: float) -> None:
    """A post behind 1 km of 300 mm/h leaves the noise, and the labels; a ship moves elsewhere."""
    bodies = [point("post", 0, 5000, rcs_dbsm=rcs), point("ship", 3000, 3000, speed_kn=9)]
    cell = {"outline_m": [[-500, 2000], [-500, 3000], [500, 3000], [500, 2000]], "rain_mm_h": 300.0}
    made = (wet(bodies, FEW | radar, noise=True, rain_cell=given) for given in ([], [cell]))
    dry, rain = (rs.Simulator(each, "fast", 3, labels=True) for each in made)
    assert [BODY in np.asarray(sim.scan().labels) for sim in (dry, rain)] == [True, False]
    ratio = dry.source_powers(0)[BODY].max() / rain.source_powers(0)[BODY].max()
    assert 10.0 * np.log10(ratio) == pytest.approx(2.0 * rain_db_per_km(300.0, "h", 9.41e9), abs=0.02)


def test_a_cell_too_light_to_weaken_anything_has_an_echo() -> None:
    """In S band a rate of 0.001 mm/h takes less than a float32 can tell from nothing."""
    light = wet(radar={"frequency_hz": 3.05e9}, rain_cell=[ROUND | {"rain_mm_h": 0.001}])
    assert rs.Simulator(light, "fast", seed=1).scan().power.max() > 0.0


def test_bytes_do_not_depend_on_where_a_run_begins() -> None:
    cell = {"outline_m": HOOK, "rain_mm_h": 30.0, "speed_kn": 30, "course_deg": 200}
    made = wet([point("ship", 2500, 300, speed_kn=9)], FEW, noise=True, sea_state=3, rain_mm_h=1.0, rain_cell=[cell])
    runs = rs.Simulator(made, "fast", seed=2), rs.Simulator(made, "fast", seed=2)
    runs[0].scan(), runs[0].scan(), runs[1].skip_to(2)
    assert runs[0].scan().field.tobytes() == runs[1].scan().field.tobytes()


ROUND = {"position_m": [0, 0], "radius_m": 500, "rain_mm_h": 5}


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ([ROUND] * 1000, "rain_cell: a list of 1000 values is not allowed; a list of at most 50"),
        ([ROUND | {"radius_m": 0}], r"rain_cell\[0\].radius_m: 0 is not allowed; a finite number from 50 to"),
        ([ROUND | {"radius_m": np.nan}], "radius_m: nan is not allowed"),
        ([ROUND | {"rain_mm_h": 301}], "rain_mm_h: 301 is not allowed; a finite number above 0 up to 300"),
        ([{"rain_mm_h": 5}], "position_m: a rain cell needs position_m and radius_m, or outline_m; add"),
        ([ROUND | {"outline_m": HOOK}], "position_m: outline_m already says where the cell is; remove"),
        ([{"outline_m": HOOK[:2], "rain_mm_h": 5}], "outline_m: 2 corners enclose nothing; give 3 to 100"),
        ([{"outline_m": [HOOK[0], HOOK[2], HOOK[1], HOOK[7]], "rain_mm_h": 5}], "outline_m: it crosses or touches itself"),
        ([{"outline_m": [[0, 0], [1e3, 0], [0, 1]], "rain_mm_h": 5}], "outline_m: it encloses 500 m2; give 10000 m2"),
    ],
)  # fmt: skip
def test_errors_name_key_value_range_and_remedy(cells: list[dict[str, Any]], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        wet(rain_cell=cells)


def test_a_ring_that_is_closed_by_its_first_corner_is_the_same_cell() -> None:
    assert cells_of({"outline_m": [*HOOK, HOOK[0]]}) == cells_of({"outline_m": HOOK})
