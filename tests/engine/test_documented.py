from typing import Any

import numpy as np
import pytest

from radar_service.engine.documented import AzimuthHits, DocumentedEngine
from radar_service.propagation.multipath import printed_two_ray_factor
from radar_service.radar.patterns import printed_gain
from radar_service.receive.documented_receiver import chirp, chirp_sum, compress, pulse_times, sample_delay, window
from radar_service.records.fidelity import Fidelity
from radar_service.world.scene import Scene
from tests import scenes
from tests.reference.printed_formulas import predicted_psf

RADAR = {"range_max_m": 1500.0, "height_m": 10.0}
EMBREE = Fidelity("documented", engine="documented")
ONE_BY_ONE = Fidelity("documented", engine="documented", tracer="moller_trumbore")


def scene(*bodies: dict[str, Any], environment: Any = None, own_ship: Any = None, **radar: Any) -> Scene:
    named = [{"name": f"body {i}"} | body for i, body in enumerate(bodies)]
    return scenes.scene(named, radar=RADAR | radar, environment=environment or {}, own_ship=own_ship or {})


def point(distance: float, bearing_deg: float, up: float = 10.0) -> dict[str, Any]:
    bearing = np.deg2rad(bearing_deg)
    position = [distance * np.sin(bearing), distance * np.cos(bearing), up]
    return {"shape": "point", "rcs_dbsm": 0, "position_m": position}


def plate(distance: float, bearing_deg: float, size: float) -> dict[str, Any]:
    position = point(distance, bearing_deg)["position_m"]
    return {"shape": "plate", "width_m": size, "height_m": size, "position_m": position, "heading_deg": bearing_deg - 180}


def chain(*bodies: dict[str, Any], fidelity: Fidelity = EMBREE, seed: int = 0, **settings: Any) -> DocumentedEngine:
    return DocumentedEngine(scene(*bodies, **settings), fidelity, seed)


class Listening(DocumentedEngine):
    """The chain, remembering the hits that it weighed last."""

    hits: AzimuthHits

    def amplitude(self, hits: AzimuthHits) -> np.ndarray:
        self.hits = hits
        return super().amplitude(hits)


def listening(*bodies: dict[str, Any], **settings: Any) -> Listening:
    return Listening(scene(*bodies, **settings), EMBREE, 0)


def peak(power: np.ndarray) -> tuple[int, int]:
    row, column = np.unravel_index(int(np.argmax(power)), power.shape)
    return int(row), int(column)


@pytest.mark.parametrize(("distance", "bearing_deg"), [(401.0, 30), (700.0, 120), (1100.0, 250), (900.0, 0), (300.0, 359.5)])
def test_points_stand_at_their_bearing_and_range(distance: float, bearing_deg: float) -> None:
    made = chain(point(distance, bearing_deg), rays=1)
    _, power = made.scan(0)
    row, column = peak(power)
    assert row == bearing_deg * 2  # a point on a boresight
    assert abs(made.range[column] - distance) <= made.range[1] / 2 + 1e-9  # eq. 14 rounds to a sample


def test_meshes_stand_at_their_bearing_and_range_whatever_the_heading_of_own_ship() -> None:
    made = chain(plate(700.0, 120.0, 20.0), own_ship={"heading_deg": 70}, rays=500)
    row, column = peak(made.scan(0)[1])
    assert abs(row / 2 - 120) <= 1.0  # the plate is 1.6 degrees wide, and rays are random on it
    assert abs(made.range[column] - 700.0) <= made.range[1]  # rounding, and 20 m of plate seen slightly aslant


def test_a_point_gives_the_amplitude_of_eq_8_and_the_phase_of_eq_11() -> None:
    made = chain(point(800.0, 90.4, up=24.0), environment={"gas_db_per_km": 0.3}, rays=1)
    distance, elevation = np.hypot(800.0, 14.0), np.arctan2(14.0, 800.0)
    field = made.azimuth_field(0, 180)
    gain = (printed_gain(np.deg2rad(0.4), np.deg2rad(3.9)) * printed_gain(elevation, np.deg2rad(25))) ** 2
    expected = gain / (distance**2 + 1) * 10 ** (-0.3 * 2 * distance / 10_000)
    wavelength = 299_792_458.0 / 9.41e9
    turned = expected * np.exp(4j * np.pi * distance / wavelength)
    # complex64, relative; and 4 pi R / lambda of 3e5 rad from a range rounded at 1e-13 m
    assert field[round(distance / made.range[1])] == pytest.approx(turned, rel=1e-5)


def test_multipath_multiplies_the_magnitude_squared_of_eq_12() -> None:
    wet, dry = (
        chain(point(800.0, 90.0, up=6.0), environment={"multipath": on, "sea_state": 2}, rays=1) for on in (True, False)
    )
    factor = printed_two_ray_factor(
        800.0, 6.0, 10.0, 299_792_458.0 / 9.41e9, earth_radius=4 / 3 * 6_371_000.0, wave_height=(0.04 + 0.1 * 2**2.1) / 4
    )
    ratio = wet.azimuth_field(0, 180)[400] / dry.azimuth_field(0, 180)[400]
    assert ratio == pytest.approx(np.abs(factor) ** 2, rel=1e-5)  # complex64


def test_the_field_is_the_literal_sum_over_the_hits() -> None:
    made = listening(plate(500.0, 45.0, 30.0), rays=3000)
    field = made.azimuth_field(0, 90)
    hits = made.hits
    assert hits.range.size > 20
    sent = chirp(pulse_times(10e-6, 75e6), 50e6, 10e-6)
    phase = 4 * np.pi * hits.range * 9.41e9 / 299_792_458.0
    received = chirp_sum(sample_delay(hits.range, 75e6), made.amplitude(hits), phase, sent, field.size)
    reference = compress(received, sent, window("hamming", sent.size), field.size)
    assert np.abs(field - reference).max() < 1e-6 * np.abs(reference).max()  # complex64


def test_both_tracers_see_the_same_echoes() -> None:
    bodies = {"shape": "hull", "length_m": 80, "beam_m": 15, "height_m": 12, "position_m": [300, 300, 0]}, plate(600, 30, 20)
    by_tree, by_list = (chain(*bodies, fidelity=f, rays=2000) for f in (EMBREE, ONE_BY_ONE))
    for index in (60, 90, 91):
        tree, one_by_one = by_tree.azimuth_field(0, index), by_list.azimuth_field(0, index)
        assert np.abs(tree).max() > 0
        # complex64; no ray of 2000 is within 1e-6 of an edge
        assert np.abs(tree - one_by_one).max() <= 1e-6 * np.abs(tree).max()


def test_azimuths_do_not_depend_on_order_and_seeds_matter() -> None:
    bodies = (plate(500.0, 45.0, 30.0),)
    first, second = chain(*bodies, rays=200), chain(*bodies, rays=200)
    field, _ = first.scan(1)
    for index in (95, 3, 90):
        assert second.azimuth_field(1, index).tobytes() == field[index].tobytes()
    assert first.azimuth_field(2, 90).tobytes() != field[90].tobytes()
    assert chain(*bodies, rays=200, seed=1).azimuth_field(1, 90).tobytes() != field[90].tobytes()


def test_bodies_behind_others_are_occluded() -> None:
    front, back = plate(400.0, 45.0, 60.0), point(600.0, 45.0)
    alone = np.abs(chain(back, rays=50).azimuth_field(0, 90))
    both = np.abs(chain(front, back, rays=50).azimuth_field(0, 90))
    k = int(np.argmax(alone))
    assert alone[k] > 0 and both[k] < 1e-3 * alone[k]  # what is left are sidelobes of the plate
    beside = chain(plate(400.0, 44.0, 4.0), back, rays=50)
    assert np.abs(beside.azimuth_field(0, 90))[k] > 0.9 * alone[k]


def test_points_answer_within_one_and_a_half_beamwidths_both_ways() -> None:
    near, outside = (chain(point(500.0, 45.0 + off), rays=1).azimuth_field(0, 90) for off in (5.84, 5.86))
    assert np.abs(near).max() > 0 and not outside.any()
    high, above = (
        chain(point(500.0, 45.0, up=10 + 500 * np.tan(np.deg2rad(el))), rays=1).azimuth_field(0, 90) for el in (37.4, 37.6)
    )
    assert np.abs(high).max() > 0 and not above.any()


def test_hits_lie_on_the_side_of_boresight_where_the_body_is() -> None:
    made = listening(plate(500.0, 48.0, 10.0), rays=20_000)
    made.azimuth_field(0, 90)
    assert made.hits.range.size > 10
    assert np.abs(np.rad2deg(made.hits.azimuth) - 3.0).max() < np.rad2deg(5 / 499)  # half the plate
    assert np.abs(made.hits.height - 10.0).max() < 5.0 + 1e-6


def test_a_wide_body_is_hit_far_from_its_centre() -> None:
    made = listening(plate(300.0, 45.0, 200.0), rays=500)
    made.azimuth_field(0, 66)
    assert made.hits.range.size > 10  # 12 degrees beside the centre, within the 18 that half the plate spans


def test_bodies_move_between_scans() -> None:
    mover = point(500.0, 90.0) | {"speed_kn": 20, "course_deg": 90}
    made = chain(mover, rays=1)
    ranges = [made.range[peak(made.scan(k)[1])[1]] for k in (0, 8)]
    # 8 turns of 2.5 s at 20 kn; both rounded to a sample
    assert ranges[1] - ranges[0] == pytest.approx(20 * 20 * 1852 / 3600, abs=made.range[1])


def test_the_ground_is_hit_from_where_the_lowest_ray_meets_it() -> None:
    made = listening(environment={"ground_plane": True}, rays=20_000)
    field = made.azimuth_field(0, 100)
    lowest = 10.0 / np.sin(np.deg2rad(37.5))
    # 20 000 rays over 75 degrees leave gaps of 0.004 degrees: ten of them are 0.04, which moves 16.43 m by 15 mm
    assert lowest <= made.hits.range.min() < lowest + 0.015
    assert np.abs(made.hits.height).max() < 1e-6 and np.abs(field).max() > 0  # rounding of ranges of a km
    assert not chain(rays=2000).azimuth_field(0, 100).any()


def test_the_ground_occludes_bodies_under_it() -> None:
    sunk = chain(point(300.0, 45.0, up=-5.0), environment={"ground_plane": True}, rays=1, seed=3)
    assert not np.abs(sunk.azimuth_field(0, 90)[145:155]).max() > 1e-7  # a seen point would make 1.1e-5 at 300 m


def test_the_share_of_rays_that_hit_is_the_solid_angle() -> None:
    made = listening(plate(500.0, 45.0, 10.0), rays=100_000)
    made.azimuth_field(0, 90)
    hits = made.hits.range.size
    width = 2 * np.arctan(5 / 500)
    expected = 100_000 * width**2 / (3 * np.deg2rad(3.9) * 3 * np.deg2rad(25))
    assert hits == pytest.approx(expected, abs=4 * np.sqrt(expected))  # 4 sigma of the count


def test_a_one_antenna_radar_is_eclipsed_while_it_transmits() -> None:
    near, far = point(200.0, 45.0), point(1499.5, 45.0)
    separate, eclipsed = (
        chain(near, far, rays=1, eclipsing=on, range_max_m=2000).azimuth_field(0, 90) for on in (False, True)
    )
    k = round(1499.5 / 1.99861638)
    assert np.abs(eclipsed[k]) == pytest.approx(np.abs(separate[k]), rel=1e-2)  # c T / 2: 1498.96 m; sidelobes of the near
    assert np.abs(eclipsed[100]) < 0.15 * np.abs(separate[100])  # 1.33 of 10 us are received, where the window is lowest


def test_a_blind_sector_is_silent() -> None:
    settings: dict[str, Any] = {"own_ship": {"heading_deg": 40}, "blind_sectors_deg": [[0, 10]], "rays": 1}
    made = chain(point(500.0, 45.0), **settings)
    assert not made.azimuth_field(0, 81).any() and not made.azimuth_field(0, 99).any()
    assert made.azimuth_field(0, 101).any() and made.azimuth_field(0, 79).any()


def test_one_tile_is_the_whole_scan() -> None:
    made = chain(point(500.0, 45.0), rays=1)
    ((start, field, power),) = made.tiles(0)
    assert start == 0 and field.dtype == np.complex64 and power.dtype == np.float32
    assert np.array_equal(power, made.scan(0)[1])


def test_the_picture_of_a_point_against_the_predicted_point_spread() -> None:
    azimuths, rate = 1800, 400e6
    made = chain(point(199.7867, 45.0), azimuths=azimuths, sample_rate_hz=rate, window="none", range_max_m=240.0, rays=1)
    _, power = made.scan(0)
    row, column = peak(power)
    picture = power / power.max()
    offset = (np.arange(-15, 16)) * 2 * np.pi / azimuths
    across, predicted = picture[row - 15 : row + 16, column], predicted_psf(0.0, offset, 2.998, np.deg2rad(3.9))
    # eq. 20 forgets the beam that the rays bring along: 3.95 degrees for 3.9 (docs/specification.md, errata row 7), and a
    # Gaussian that is wider by a share s stands higher by 2 s / e where the difference is greatest; 0.002 is half the last
    # digit of the 3.95
    assert np.abs(across - predicted).max() == pytest.approx(2 * np.exp(-1) * 0.0125, abs=0.002)
    along = picture[row, column - 30 : column + 31]
    range_offset = np.arange(-30, 31) * made.range[1]
    # in range the unweighted chirp keeps to the sinc^2 within tau / T, 1.5 % at 11 m, twice for the square
    assert along == pytest.approx(predicted_psf(range_offset, 0.0, 2.99792458, np.deg2rad(3.9)), abs=2 * 75e-9 / 10e-6)


def test_a_hamming_reference_makes_the_picture_wider_than_predicted() -> None:
    made = chain(point(199.7867, 45.0), sample_rate_hz=400e6, range_max_m=240.0, rays=1)
    power = made.scan(0)[1]
    row, column = peak(power)
    along = power[row, column:] / power.max()
    half = float(np.interp(-0.5, -along[:15], np.arange(15))) * made.range[1]
    predicted = 0.442946 * 2.99792458
    # docs/specification.md, errata row 11; samples 0.37 m apart, joined by lines
    assert half / predicted == pytest.approx(1.47, abs=0.01)
