"""The draws of ships and the fields of the oracle."""

from dataclasses import replace

import numpy as np
import pytest

from tests.reference import ship_fields
from tests.reference.ship_draws import AZIMUTHS, KINDS, STEP, drawn


def test_the_metal_is_where_the_beam_points_at_its_crossing() -> None:
    """To half a spoke; all kinds, ranges and scans as the table says."""
    draws = [drawn(number, 7) for number in range(60)]
    assert str(drawn(4, 7)) == str(draws[4]) != str(drawn(4, 8))
    assert [draw.kind for draw in draws[:10]] == list(KINDS)
    for draw in draws:
        place = draw.place(draw.crossing * STEP)
        off = np.angle(np.exp(1j * (np.arctan2(*place) - 2.0 * np.pi * draw.crossing / AZIMUTHS)))
        early = draw.crossing == 0 and off < 0.0  # the beam has passed it before the start
        assert abs(off) <= np.pi / AZIMUTHS + 1e-9 or early, str(draw)
        assert 149.9 < np.hypot(*place) < 14_001.0
        assert (draw.spokes >= 0).all() and draw.crossing in draw.spokes
    assert {draw.crossing // AZIMUTHS // 4000 for draw in draws} == {0, 2}


@pytest.mark.parametrize("number", [7, 12, 28])
def test_quadrature_is_brute_force(number: int) -> None:
    """Equal elements of 1/20 of a wavelength, whose sum errs by (2 k lambda / 20)^2 / 24 = 1.6 % edge-on."""
    draw = drawn(number, 5)
    hull = {**draw.bodies[0], "length_m": 0.6, "width_m": 0.35, "height_m": 0.9}
    draw = replace(draw, bodies=(hull, *draw.bodies[1:]))
    ranges = np.hypot(np.hypot(*draw.place(draw.crossing * STEP)), draw.setting.antenna_height) + np.linspace(-40.0, 40.0, 9)
    quick, brute = (
        ship_fields.field(draw, ranges, draw.spokes[3:6:2], size) for size in (None, draw.setting.wavelength / 20)
    )
    assert (
        np.abs(quick - brute).max() < 0.02 * np.abs(ship_fields.field(draw, ranges, draw.spokes[3:6:2], shadows=False)).max()
    )
