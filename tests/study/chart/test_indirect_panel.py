"""Indirect echoes of the chart: a corner, whose power all methods have, and the funnel that makes them."""

import numpy as np

from radar_service.radar.structure_reflection import NEAREST
from radar_service.radar.structure_shadow import structure_reflectors
from radar_service.study.chart.indirect_panel import (
    CELLS,
    COMPARED,
    EACH,
    HELD,
    METHODS,
    FalseShip,
    indirect_points,
    with_funnel,
)
from tests.study.chart.test_dents_panel import BODY, WALL, upright_ship

CORNER = BODY | {"shape": "trihedral", "edge_m": 0.4, "heading_deg": 180.0, "position_m": [0.0, 300.0, 12.0]}


def test_indirect_echoes_of_a_corner_have_the_power_of_every_aspect() -> None:
    """In the middle of its lobe a corner looks the same a scan later: all methods agree, in the cells of which it fills few."""
    done: list[int] = []
    points = indirect_points(upright_ship(CORNER), 2, lambda: done.append(1))
    assert len(points) == METHODS and len(done) == 2 * METHODS
    assert [point.family for point in points] == [HELD] * len(CELLS) + [EACH]
    assert all(point.error_db is not None and abs(point.error_db) < 0.2 for point in points)
    assert {point.setting: point.preset for point in points if point.preset} == {
        "cells of 1 rad": "balanced",
        "all centres": "reference",
    }


def test_the_funnel_stands_abeam_of_the_ship_and_needs_a_pattern_that_allows_it() -> None:
    made = with_funnel(upright_ship(CORNER))
    assert made is not None
    (reflector,) = structure_reflectors(made.radar)
    assert abs(reflector.structure.bearing - np.pi / 2.0) < 1e-6 and NEAREST < np.pi / 2.0
    false = FalseShip(made)
    lit = 720 + 180 + np.arange(-1, COMPARED - 1)
    one, three = (false.powers(false.every_aspect(), lit[:count], 1) for count in (1, 3))
    assert one[0] == three[0] > 0.0
    assert with_funnel(upright_ship(CORNER, pattern="gaussian")) is None
    assert indirect_points(upright_ship(CORNER, pattern="gaussian"), 1, lambda: None) == []


def test_a_ship_out_of_range_has_no_points() -> None:
    assert indirect_points(upright_ship(WALL | {"position_m": [0.0, 3000.0, 0.0]}), 1, lambda: None) == []
