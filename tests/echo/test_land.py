"""Land under way, piece by piece: what is passed when, and what keeps a range history."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.engine.land_scenes import FINE, OWN_SHIP, SLAB, azimuths_of, coast, on_grid, with_points
from tests.kernels.both import both
from tests.scenes import scene
from tests.test_motion import SWAY


def test_what_is_near_or_high_for_its_distance_keeps_a_range_history(tmp_path: Path) -> None:
    """A tenth of the echoes at most. Beyond the border of 150 m only heights by which phases turn by 0.04 rad at half a beam."""
    prepared = on_grid(coast(tmp_path, environment={"multipath": False}))
    assert prepared.land is not None
    border = prepared.land.passages.border(prepared.land.passages.way_at(1024.0))
    assert border == 150.0
    azimuths, radar = azimuths_of(prepared.scene, 1024), prepared.scene.radar
    near = prepared.land.near(azimuths).position - prepared.scene.antenna(azimuths.middle)[0]
    distance = np.hypot(near[:, 0], near[:, 1])
    assert 0 < len(distance) < 0.1 * prepared.land.echoes_about(azimuths)
    way = 8 * 1852 / 3600 / (2 * np.pi / radar.rotation_period)
    slant = np.abs(near[:, 2] ** 2 - 13.0**2) / 2 / distance**2
    phase = 4 * np.pi / radar.wavelength * slant * way * radar.beamwidth / 2
    assert np.all((distance < border + 4.0) | (phase > 0.037))  # own ship moves by 3.2 m over these pieces


def test_what_is_high_for_its_distance_keeps_a_range_history() -> None:
    """300 m off at 8 kn and 1.2 degrees: 0.06 rad against the ground 55 m high, 0.006 rad 20 m high; the limit is 0.04 rad."""
    made = scene([SLAB], radar=FINE, own_ship=OWN_SHIP)
    antenna = np.array([0.0, 0.0, 15.0])
    for height, near in ((20.0, 0), (55.0, 1)):
        prepared = with_points(on_grid(made), np.array([[300.0, 0.0, height]]), antenna)
        assert prepared.land is not None
        assert len(prepared.land.near(azimuths_of(made, 512)).echoes) == near


def test_each_point_is_passed_once_a_scan() -> None:
    """300 points all round, but for 23 degrees about north, where scans begin: none is lost and none is twice."""
    made = scene([SLAB], radar={**FINE, "range_max_m": 3500}, own_ship={"course_deg": 100.0, "speed_kn": 25.0})
    rng = np.random.default_rng(2)
    bearing, distance = rng.uniform(0.2, 2 * np.pi - 0.2, 300), rng.uniform(240.0, 3000.0, 300)
    position = np.column_stack([distance * np.sin(bearing), distance * np.cos(bearing), np.full(300, 2.0)])
    prepared = with_points(on_grid(made), position, np.array([0.0, 0.0, 15.0]))
    assert prepared.land is not None
    for scan in range(2):
        pieces = [prepared.land.passages.piece(number) for number in range(scan * 32, (scan + 1) * 32)]
        assert sum(len(piece.row) + len(piece.near.echoes) for piece in pieces) == 300


def test_a_point_beside_own_ship_is_one_echo_at_every_azimuth() -> None:
    """Own ship passes by 3 m at 8 kn. Within 16 m boresight may point at the point twice, or never. Before and after that, it
    is an echo while the beam may meet it, half of the turn at most (12 beamwidths each side, and pieces)."""
    made = scene([SLAB], radar=FINE, own_ship={"course_deg": 0.0, "speed_kn": 8.0})
    prepared = with_points(on_grid(made), np.array([[3.0, 22.0, 2.0]]), np.array([0.0, 0.0, 15.0]))
    assert prepared.land is not None
    counts, distances = [], []
    for first in range(0, 4 * 2048, 32):
        azimuths = azimuths_of(made, first)
        counts.append(len(prepared.land.near(azimuths).echoes))
        distances.append(np.linalg.norm((prepared.scene.antenna(azimuths.middle)[0] - [3.0, 22.0, 15.0])[:2]))
    beside = np.array(distances) < 16.0
    assert beside.sum() > 100 and (np.array(counts)[beside] == 1).all()
    assert 0.0 < np.mean(np.array(counts)[~beside]) < 0.5


@pytest.mark.parametrize("own_ship", [OWN_SHIP, {"heading_deg": 40.0, "course_deg": 40.0, "speed_kn": 8.0, **SWAY}])
@pytest.mark.parametrize("azimuths", [1024, 360])
def test_what_is_passed_is_what_numpy_says(tmp_path: Path, own_ship: dict[str, Any], azimuths: int) -> None:
    """Of a coast, in pieces of 22 and of 64 degrees. The tolerance is 1e3 roundings of 1e5 azimuths, each 0.6 mm 2 km off."""
    land = on_grid(coast(tmp_path, own_ship, radar={"azimuths": azimuths})).land
    assert land is not None
    for number in (0, 7, azimuths):
        compiled, by_numpy = both(lambda: land.passages.piece(number))  # noqa: B023
        assert len(compiled.row) > 100
        np.testing.assert_allclose(compiled.row, by_numpy.row, rtol=0.0, atol=1e-8)
        np.testing.assert_array_equal(compiled.near_points, by_numpy.near_points)
