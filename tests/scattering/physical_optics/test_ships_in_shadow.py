"""Metal behind breakwaters and passing ships, in all presets, against `tests.reference.ship_fields`, which shares no code."""

from typing import Any

import numpy as np
import pytest

from tests.reference.metal_on_water import EARTH, LIGHT, Setting
from tests.reference.ship_draws import AZIMUTHS, PERIOD, SEA_AT, Case, Table
from tests.reference.ship_tracks import KNOT
from tests.scattering.physical_optics.test_ships_under_way import USUAL, outcome

FREQUENCY = 3.05e9
BOX = {"shape": "box", "scattering": "optics", "width_m": 6.0, "length_m": 3.0, "height_m": 4.0, "heading_deg": 0.0}


def case(*bodies: Table, crossing: int = 0) -> Case:
    """A radar 15 m up in S band over the sea; the first body is the metal."""
    setting = Setting(
        wavelength=LIGHT / FREQUENCY, antenna_height=15.0, polarization="h", beamwidth_el=np.deg2rad(25.0), sea=True,
        permittivity=SEA_AT[FREQUENCY], earth_radius=EARTH,
    )  # fmt: skip
    radar = {
        "frequency_hz": FREQUENCY, "polarization": "h", "height_m": 15.0, "bandwidth_hz": 20e6, "beamwidth_deg": 1.9,
        "azimuths": AZIMUTHS, "rpm": 24.0, "beamwidth_el_deg": 25.0, "range_max_m": 800.0,
    }  # fmt: skip
    return Case(0, "wall", setting, radar, crossing, bodies)


def metal(north: float, **more: Any) -> Table:
    return {"name": f"metal {north:.0f}", "position_m": [0.0, north, 0.0], **BOX, **more}


def wall(length: float, **more: Any) -> Table:
    """A silent breakwater across the line of sight, 40 m before the metal at 500 m, that hides the sea before it."""
    return {
        "name": "wall", "shape": "box", "rcs_dbsm": -100.0, "width_m": length, "length_m": 4.0, "height_m": 1.5,
        "position_m": [0.0, 458.0, 0.0], "heading_deg": 0.0, **more,
    }  # fmt: skip


def under_way(body: Table, speed: float, course: float, time: float) -> Table:
    """The body with a straight course [degrees] at a speed [kn], so that it is where the table has it at a time [s]."""
    moved = speed * KNOT * time * np.array([np.sin(np.deg2rad(course)), np.cos(np.deg2rad(course))])
    east, north, up = body["position_m"]
    place = [east - moved[0], north - moved[1], up]
    return {**body, "position_m": place, "speed_kn": speed, "course_deg": course}


# Every other spoke is enough for the suite: the field changes over some of them.
spokes = pytest.mark.parametrize("every", [2, pytest.param(1, marks=pytest.mark.study)], ids=["fewer", "all"])


def assert_right(bodies: list[Table], every: int, crossing: int = AZIMUTHS) -> None:
    """All presets have the oracle's field in the passage of the second scan, to the error that draws of ships usually keep."""
    result = outcome(case(*bodies, crossing=crossing), every=every)
    assert max(result.error.values()) < USUAL, str(result)


@spokes
@pytest.mark.parametrize("length", [pytest.param(28.0, marks=pytest.mark.study), 100.0], ids=["of-28-m", "of-100-m"])
def test_a_breakwater_takes_the_way_by_the_sea_however_long_it_is(length: float, every: int) -> None:
    """It hides the sea before the box, which so loses 13.07 dB. Long ones had hidden nothing."""
    assert_right([metal(501.5), wall(length)], every)


@spokes
def test_a_breakwater_shadows_metal_that_sails_behind_it(every: int) -> None:
    assert_right([under_way(metal(501.5), 10.0, 70.0, PERIOD), wall(100.0, heading_deg=5.0)], every)


@spokes
@pytest.mark.parametrize("moves", [True, pytest.param(False, marks=pytest.mark.study)], ids=["under-way", "at-rest"])
def test_the_shadow_of_a_passing_ship_moves_over_metal(moves: bool, every: int) -> None:
    """A silent hull 25 m nearer crosses the line of sight at 20 kn: its edge moves by 4 cm from spoke to spoke. The metal shows a
    corner, so what is seen of its sides is what its edges leave."""
    turned = metal(501.5, heading_deg=25.0)
    target = under_way(turned, 10.0, 250.0, PERIOD) if moves else turned
    other = wall(6.0, height_m=2.5, position_m=[2.0, 475.0, -0.5])
    assert_right([target, under_way(other, 20.0, 80.0, PERIOD)], every)


@spokes
def test_metal_at_rest_has_no_way_by_the_sea_through_a_passing_ship(every: int) -> None:
    """It had kept that way, as shadows of ships under way fell along the direct line alone."""
    assert_right([metal(501.5), under_way(wall(20.0), 8.0, 90.0, PERIOD)], every)
