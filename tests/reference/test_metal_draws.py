"""The draws and the spokes of the oracle."""

import os
from dataclasses import replace

import numpy as np
import pytest

from tests.reference import metal_draws
from tests.reference import metal_on_water as oracle
from tests.reference.metal_draws import ROWS, Draw, drawn

RANGES = (np.arange(400) + 0.5) * metal_draws.CELL / 1.5
FREE = oracle.Setting(sea=False, earth_radius=np.inf)


def small_plate(**changes: object) -> Draw:
    """A plate of 0.2 m square to the antenna, at 1 km."""
    faces = tuple(oracle.plate(0.2, 0.2))
    made = Draw(6, 0, "plate", FREE, faces, 1000.0, 1.0, 15.0, 1.0 + np.pi, 0.2, 0.2)
    return replace(made, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize("row", ROWS)
def test_draws_are_what_the_table_says(row: int) -> None:
    """The same number and seed give the same draw; every one has a finite amplitude, and a neighbourhood that is not zero."""
    draws = [drawn(row, i, 3) for i in range(8)]
    assert str(draws[4]) == str(drawn(row, 4, 3)) != str(drawn(row, 4, 2))
    low, high = {5: (60, 400), 6: (60, 2000)}.get(row, (25 if row == 2 else 100, 4000))
    for draw in draws:
        assert low <= draw.distance <= high and 5.0 <= draw.setting.antenna_height <= 40.0
        assert np.isfinite(metal_draws.amplitude(draw))
    assert metal_draws.local_rms(draws[0], 4) > 0.0


def test_a_spoke_holds_the_amplitude_of_a_small_body() -> None:
    """On boresight its root energy over that of 1 m^2 is the root of its cross-section; 4 pi A^2 / lambda^2."""
    draw = small_plate()
    boresight = np.array([draw.bearing])
    field = metal_draws.spoke_field(draw, RANGES, boresight, np.array([draw.time]))
    ratio = np.linalg.norm(field, axis=1) / metal_draws.unit_energy(draw, RANGES, boresight)
    assert ratio[0] == pytest.approx(metal_draws.amplitude(draw), rel=1e-4)
    assert ratio[0] == pytest.approx(2 * np.sqrt(np.pi) * 0.04 / FREE.wavelength, rel=1e-3)


def test_a_turning_plate_has_the_pattern_of_its_aspect_at_each_spoke() -> None:
    """cos sinc(k D sin) of the angle turned since the crossing; the near field of 0.2 m at 1 km is 2e-3 rad."""
    draw = small_plate(turn=np.deg2rad(40.0))
    time = draw.time + np.array([-0.02, 0.0, 0.05])
    field = metal_draws.spoke_field(draw, RANGES, np.full(3, draw.bearing), time)
    turned = np.deg2rad(40.0) * (time - draw.time)
    exact = np.cos(turned) * np.sinc(2 * 0.2 * np.sin(turned) / FREE.wavelength)
    level = np.linalg.norm(field, axis=1)
    assert level / level[1] == pytest.approx(np.abs(exact), abs=2e-3)


def test_a_wall_hides_what_it_is_drawn_to_hide() -> None:
    """Of a plate square on, in free space, a share of the amplitude is left; elements of 1/128 cut by area."""
    for tall in (True, False):
        wall = metal_draws.Wall(0.6, 0.35, tall, 1.0)
        draw = small_plate(wall=wall, distance=5000.0)
        assert metal_draws.amplitude(draw) / metal_draws.amplitude(replace(draw, wall=None)) == pytest.approx(0.65, abs=4e-3)


@pytest.mark.study
@pytest.mark.parametrize("row", [1, 3, 4, 5])
def test_quadrature_is_brute_force_on_the_draws(row: int) -> None:
    """Elements of lambda/16 and the quadrature: equal sums err by (k lambda / 16)^2 / 6 = 2.6 % edge-on, and by 2 % where a
    shadow's edge runs between elements; of the level of the neighbourhood. Bodies below 3 m, METAL_DRAWS of them."""
    count, number = int(os.environ.get("METAL_DRAWS", "10")), 0
    for _ in range(count):
        while (draw := drawn(row, number, 4)).width * draw.height > 9.0:
            number += 1
        number += 1
        quick, brute = metal_draws.amplitude(draw), metal_draws.amplitude(draw, draw.setting.wavelength / 16)
        assert abs(quick - brute) < 0.05 * max(quick, metal_draws.local_rms(draw)), str(draw)
