"""The one-way link to a beacon, against the one-way equation, the two-ray factor, and walls."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.frames import effective_earth_radius
from radar_service.propagation.multipath import two_ray_factor
from radar_service.stages.beacons.link import BeaconLink
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import point, scene

RADAR = {"range_max_m": 6000, "azimuths": 360, "beamwidth_deg": 4, "gain_dbi": 30.0, "power_w": 10e3, "height_m": 15}
FLAT = {"earth": "flat"}
NOW = np.zeros(1)


def linked(of: rs.Scene, key: int = 0) -> BeaconLink:
    earth = effective_earth_radius(of.environment.earth_factor)
    return BeaconLink(of, key, OcclusionScene(of.bodies, earth))


def racon(distance: float = 4000.0, radar: Any = None, environment: Any = None, others: Any = (), **body: Any) -> rs.Scene:
    made = point("racon", 0, distance, **({"racon": {"letter": "K"}} | body))
    return scene([made, *others], radar=RADAR | (radar or {}), environment=environment or FLAT)


def level_db(of: rs.Scene, time: float = 0.0) -> float:
    return float(10 * np.log10(linked(of).at(np.array([time])).transfer[0]))


@pytest.mark.parametrize("distance", [500.0, 4000.0])
def test_the_one_way_equation(distance: float) -> None:
    """P G lambda^2 / (4 pi R)^2: gain in dB less 32.45 + 20 log10(km MHz), the constant to half its last digit."""
    assert level_db(racon(distance)) == pytest.approx(30.0 - 32.45 - 20 * np.log10(distance / 1000 * 9410.0), abs=0.006)


def test_half_of_the_loss_counts_each_way() -> None:
    assert level_db(racon()) - level_db(racon(radar={"loss_db": 5.0})) == pytest.approx(2.5, abs=1e-9)


def test_elevation_and_weather_count_once() -> None:
    """A beam of 20 degrees has half its power 10 degrees up, where an echo loses 6 dB; 0.1 dB/km costs 0.4 dB over 4 km."""
    up = 15 + 4000 * np.tan(np.deg2rad(10.0))
    narrow = {"beamwidth_el_deg": 20.0}
    high = racon(radar=narrow, position_m=[0, 4000, up])
    assert level_db(racon(radar=narrow)) - level_db(high) == pytest.approx(
        3.0103 - 20 * np.log10(np.cos(np.deg2rad(10))), abs=0.001
    )
    dry, wet = racon(), racon(environment=FLAT | {"gas_db_per_km": 0.1})
    assert level_db(dry) - level_db(wet) == pytest.approx(0.4, abs=1e-9)


@pytest.mark.parametrize("distance", [2000.0, 4000.0, 5500.0])
def test_multipath_is_the_square_of_the_two_ray_factor(distance: float) -> None:
    """|F|^2, where an echo has |F|^4; an elevation beam of 180 degrees has the same gain for both rays (1e-3)."""
    wide = {"beamwidth_el_deg": 180.0}
    free, over_sea = (racon(distance, wide, FLAT | {"multipath": sea}, position_m=[0, distance, 8]) for sea in (False, True))
    factor = two_ray_factor(distance, 8.0, 15.0, free.radar.wavelength)
    assert level_db(over_sea) - level_db(free) == pytest.approx(20 * np.log10(np.abs(factor)), abs=0.01)


def test_triggering_has_a_threshold() -> None:
    """40 dBW and the link against a sensitivity a hundredth of a dB above and below."""
    of = racon()
    received = 70.0 + level_db(of)  # dBm at an isotropic antenna
    for more, expected in ((-0.01, True), (0.01, False)):
        link = linked(racon(racon={"letter": "K", "sensitivity_dbm": received + more}))
        assert bool(link.triggers(link.at(NOW), np.ones(1), NOW)[0]) is expected
    link = linked(racon(racon={"letter": "K", "sensitivity_dbm": received - 13.0}))
    weak = np.array([10**-1.29, 10**-1.31])  # 12.9 and 13.1 dB down in the sidelobes
    np.testing.assert_array_equal(link.triggers(link.at(np.zeros(2)), weak, np.zeros(2)), [True, False])


@pytest.mark.parametrize(
    "change, time, expected",
    [
        ({"start_s": 5.0}, 4.0, False),
        ({"start_s": 5.0}, 6.0, True),
        ({"racon": {"letter": "K", "off_s": 30.0, "on_s": 10.0}}, 15.0, False),
        ({"racon": {"letter": "K", "band": "s"}}, 0.0, False),
        ({"racon": {"letter": "K", "max_pulse_s": 1e-6}}, 0.0, False),
        ({"racon": {"letter": "K", "max_pulse_s": 50e-6}}, 0.0, True),
    ],
)
def test_what_keeps_it_silent(change: dict[str, Any], time: float, expected: bool) -> None:
    link, when = linked(racon(**change)), np.array([time])
    assert bool(link.triggers(link.at(when), np.ones(1), when)[0]) is expected


def test_it_stands_on_its_body() -> None:
    """6 m up and 10 m ahead of a ship on course 090 at 20 m/s, after 30 s; the link has its bearing and range."""
    ship = {"name": "ship", "shape": "box", "length_m": 30, "width_m": 8, "height_m": 5, "position_m": [0, 3000, 0],
            "speed_kn": 20 / 0.514444444, "course_deg": 90, "sart": {"offset_m": [0, 10, 6]}}  # fmt: skip
    link = linked(scene([ship], radar=RADAR, environment=FLAT))
    when = np.array([30.0])
    np.testing.assert_allclose(link.position(when), [[610.0, 3000.0, 6.0]], atol=1e-5)
    state = link.at(when)
    assert state.azimuth[0] == pytest.approx(np.arctan2(610, 3000), abs=1e-8)
    assert state.range[0] == pytest.approx(np.sqrt(610**2 + 3000**2 + 81), abs=1e-5)


def test_it_rolls_with_its_body() -> None:
    """A mast of 20 m at a roll of 10 degrees to starboard, beam on: its top is 3.47 m off to that side and 19.7 m up."""
    body = point("racon", 0, 3000, 0, racon={"letter": "K", "offset_m": [0, 0, 20]}, roll_deg=10, roll_period_s=8.0)
    link = linked(scene([body], radar=RADAR, environment=FLAT))
    time = np.linspace(0.0, 8.0, 161)
    east = link.position(time)[:, 0]
    assert np.abs(east).max() == pytest.approx(20 * np.sin(np.deg2rad(10)), abs=0.01)
    np.testing.assert_allclose(np.linalg.norm(link.position(time) - [0, 3000, 0], axis=1), 20.0, atol=1e-9)


def test_walls_and_the_horizon_hide_it() -> None:
    wall = {"name": "wall", "shape": "box", "length_m": 2, "width_m": 200, "height_m": 30, "position_m": [0, 2000, 0]}
    assert linked(racon()).visible(0.0) and not linked(racon(others=[wall])).visible(0.0)
    passing = wall | {"position_m": [-400, 2000, 0], "heading_deg": 0, "course_deg": 90, "speed_kn": 20 / 0.514444444}
    hidden = linked(racon(others=[passing]))
    assert hidden.visible(0.0) and not hidden.visible(20.0) and hidden.visible(40.0)
    low = racon(40_000.0, environment={"earth": "4/3"}, position_m=[0, 40_000, 5])
    assert not linked(low).visible(0.0)  # 15 m and 5 m see each other to 25.2 km
    assert linked(racon(24_000.0, environment={"earth": "4/3"}, position_m=[0, 24_000, 5])).visible(0.0)


def test_a_beacon_above_its_mesh_is_not_hidden_by_it() -> None:
    """By default half a metre above the highest point: of a box 5 m high the antenna sees it from every side."""
    for heading in (0, 90, 200):
        box = {"name": "b", "shape": "box", "length_m": 30, "width_m": 8, "height_m": 5, "position_m": [0, 3000, 0],
               "heading_deg": heading, "racon": {"letter": "K"}}  # fmt: skip
        link = linked(scene([box], radar=RADAR, environment=FLAT))
        assert link.position(NOW)[0, 2] == pytest.approx(5.5) and link.visible(0.0)


def test_a_swaying_antenna_observes_it_where_its_boresight_crosses() -> None:
    """Own ship rolls by 20 degrees; a racon 300 m up at bearing 045. The search of crossings, other code, meets it at the azimuth
    of the link (its tolerance, 1e-6 rad), which is not the bearing."""
    high = racon(position_m=[700, 700, 300])
    own = {"roll_deg": 20.0, "roll_period_s": 7.0}
    of = scene([point("racon", 700, 700, 300, racon={"letter": "K"})], radar=RADAR, environment=FLAT, own_ship=own)
    crossings = [crossing for k in range(3) for crossing in rs.Simulator(of, "fast").crossings(k)]
    for crossing in crossings:
        state = linked(of).at(np.array([crossing.time]))
        assert state.azimuth[0] % (2 * np.pi) == pytest.approx(crossing.boresight, abs=1e-6)
    assert max(abs(crossing.boresight - crossing.bearing) for crossing in crossings) > 0.02
    assert linked(high).at(NOW).azimuth[0] == pytest.approx(np.pi / 4)


@pytest.mark.parametrize("body, own_ship", [({}, {}), ({"speed_kn": 20, "course_deg": 90}, {}), ({}, {"speed_kn": 20})])
def test_the_link_follows_both_ends(body: dict[str, Any], own_ship: dict[str, Any]) -> None:
    """Four times at once have the links of each by itself, at rest and under way: rounding."""
    of = scene([point("b", 900, 2000, racon={"letter": "K"}, **body)], radar=RADAR, environment=FLAT, own_ship=own_ship)
    link, times = linked(of), np.array([0.0, 3.0, 50.0, 51.0])
    together, single = link.at(times), [link.at(times[k : k + 1]) for k in range(4)]
    for name in ("range", "azimuth", "transfer"):
        np.testing.assert_allclose(getattr(together, name), [getattr(one, name)[0] for one in single], rtol=1e-12)
    assert bool(np.ptp(together.range) > 100.0) is bool(body or own_ship)


def test_own_ships_structures_shadow_it_as_it_turns() -> None:
    """Late in a turn at 2 degrees a second a mast comes between: the one-way gain on boresight is half, in dB, of what truth
    says of the same crossing both ways (0.01 dB)."""
    mast = {"bearing_deg": 88.0, "distance_m": 6.0, "width_m": 0.8}
    own_ship = {"course_deg": 20, "speed_kn": 14, "turn_rate_deg_s": 2.0}
    of = scene(
        [point("racon", 700, -400, racon={"letter": "K"})],
        radar=RADAR | {"pattern": "cosine2", "structure": [mast]}, environment=FLAT, own_ship=own_ship,
    )  # fmt: skip
    link, sim, lost = linked(of), rs.Simulator(of, "fast"), []
    for crossing in (each for k in range(60, 75) for each in sim.crossings(k)):
        when = np.array([crossing.time])
        lost.append(-10 * np.log10(link.azimuth_gain(link.at(when), np.array([crossing.boresight]), when)[0]))
        assert crossing.structure_db == pytest.approx(2 * lost[-1], abs=0.01)
    assert max(lost) > 3.0 and min(lost) < 0.5
