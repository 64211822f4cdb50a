"""The texture of a sea with waves: the slope of the waves that move ships, of unit variance in the beam, everywhere."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.numerics.frames import effective_earth_radius
from radar_service.receive.compression import compression_for
from radar_service.stages.clutter.azimuth_rows import weight_rows
from radar_service.stages.clutter.clutter import prepare_clutter
from radar_service.stages.clutter.sea_clutter import Sea
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.wave_drawing import drawn_waves
from tests.scenes import scene

RADAR = {"range_max_m": 2500, "azimuths": 360, "beamwidth_deg": 1.5, "rpm": 24, "height_m": 15}


def sea_of(seed: int = 0, spread: float = 1.0, **own_ship: Any) -> Sea:
    environment = {"sea_state": 4, "seaway": {"seed": seed, "spread": spread, "from_deg": 40}}
    made = scene([], radar=RADAR, environment=environment, own_ship=own_ship)
    clutter = prepare_clutter(made, OcclusionScene((), effective_earth_radius(4 / 3)), compression_for(made.radar, 6), 1, 1)
    assert clutter is not None and clutter.sea is not None
    return clutter.sea


def gaussian(sea: Sea, number: NDArray[np.int64]) -> NDArray[np.float32]:
    first, stop, weights = sea.texture_beam.at(number)
    return weight_rows(weights, sea.texture.span(first, stop))


@pytest.mark.parametrize("scan", [0, 3])
def test_rows_are_the_slope_of_the_waves_that_move_ships(scan: int) -> None:
    """Along one line 600 to 1100 m off, upwind, at the row's time: the texture has the correlation 0.9 or more with the slope of
    the elevation that lifts ships, averaged over the 3.7 m of the cell; without the beam, and for own ship under way."""
    sea = sea_of(speed_kn=10, course_deg=90)
    row = round(40 / 360 * sea.texture.rows_per_scan)
    line = sea.texture.span(scan * sea.texture.rows_per_scan + row, scan * sea.texture.rows_per_scan + row + 1)[0]
    time, bearing = 2.5 * (scan + row / sea.texture.rows_per_scan), row * 2 * np.pi / sea.texture.rows_per_scan
    step = sea.column_bins * 299_792_458 / 150e6
    far = np.arange(600.0, 1100.0, step)
    made = scene([], environment={"sea_state": 4, "seaway": {"from_deg": 40}})
    assert made.environment.seaway is not None
    waves = drawn_waves(made.environment.seaway)
    line_of_sight = np.array([np.sin(bearing), np.cos(bearing)])
    place = np.array([10 * 1852 / 3600 * time, 0.0]) + far[:, None] * line_of_sight
    higher = waves.elevation(place + 0.5 * line_of_sight, np.full(len(far), time))
    slope = higher - waves.elevation(place - 0.5 * line_of_sight, np.full(len(far), time))
    seen = np.interp(far, (np.arange(len(line)) + 0.5) * step, line)
    assert np.corrcoef(seen, slope)[0, 1] > 0.9


def test_the_beams_sum_has_unit_variance_at_every_range_and_bearing() -> None:
    """Over 60 seas: 5 sigma of their independent draws, sqrt(2 / 60), for means over a third of the range and 5 bearings; 0.05
    for the table."""
    number = np.arange(0, 360, 72)
    seas = [sea_of(seed) for seed in range(1, 13)]
    drawn = np.stack([np.concatenate([gaussian(sea, number[k : k + 1]) for k in range(5)]) for sea in seas])
    for third in np.array_split(drawn, 3, axis=2):
        assert np.mean(third.astype(np.float64) ** 2) == pytest.approx(1.0, abs=0.15)
