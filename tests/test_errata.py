"""The errata of docs/specification.md, row by row: what the specification prints and what is right, both computed here."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from radar_service.engine.documented import AzimuthHits, DocumentedEngine
from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.numerics.frames import direction
from radar_service.propagation.gas_and_rain import attenuation_amplitude, printed_atmosphere
from radar_service.propagation.multipath import (
    printed_two_ray_factor,
    two_ray_factor,
    wavelength,
)
from radar_service.propagation.radar_equation import received_amplitude, two_way_phase
from radar_service.radar.patterns import PATTERNS, printed_gain, printed_two_way
from radar_service.receive.documented_receiver import (
    beam_spread,
    chirp,
    chirp_sum,
    compress,
    exact_chirp_sum,
    printed_phase,
    pulse_times,
    sample_delay,
    window,
)
from radar_service.records.fidelity import PRESETS
from radar_service.scene_file.load import load_scene
from radar_service.trace.moller_trumbore import TriangleList, printed_crossings, watertight_crossings
from radar_service.world.scene import Scene
from tests.reference.printed_formulas import printed_direction

BEAM = np.deg2rad(3.9)
BANDWIDTH, PULSE = 50e6, 10e-6
LAMBDA = wavelength(9.41e9)


def full_width(power: Any, level: float = 0.5) -> float:
    """Full width at `level` of a symmetric pattern given as a function of the offset in beamwidths."""
    return 2 * float(brentq(lambda t: float(power(t)) - level, 1e-6, 0.55))


def sampled_width(power: np.ndarray, step: float) -> float:
    """Full width at half maximum of a symmetric sampled peak, joined by lines."""
    top = int(np.argmax(power))
    return 2 * step * float(np.interp(-0.5, -power[top:] / power[top], np.arange(power.size - top)))


def scene(*bodies: dict[str, Any], **radar: Any) -> Scene:
    return load_scene({"radar": {"height_m": 10} | radar, "body": [{"name": f"body {i}"} | b for i, b in enumerate(bodies)]})


class Listening(DocumentedEngine):
    """The documented chain, remembering the hits of its last azimuth and their amplitudes."""

    hits: AzimuthHits
    amplitudes: np.ndarray

    def amplitude(self, hits: AzimuthHits) -> np.ndarray:
        self.hits, self.amplitudes = hits, super().amplitude(hits)
        return self.amplitudes


def observed(body: dict[str, Any], **radar: Any) -> Listening:
    chain = Listening(scene(body, **radar), PRESETS["documented"], seed=5)
    chain.hits = AzimuthHits(*(np.zeros(0) for _ in range(4)))
    chain.amplitudes = np.zeros(0)
    chain.azimuth_field(0, 0)
    return chain


def test_row_1_half_power_width() -> None:
    assert full_width(lambda t: printed_gain(t, 1.0)) == pytest.approx(0.318, abs=5e-4)  # half the last digit
    assert full_width(lambda t: PATTERNS["sinc2"].gain(t, 1.0)) == pytest.approx(1.0, rel=1e-9)  # root finder


def test_row_2_two_way_pattern() -> None:
    point = {"shape": "point", "rcs_dbsm": 0, "position_m": [0, 500, 10]}
    chain = DocumentedEngine(scene(point, rays=1, range_max_m=600, azimuths=7200), PRESETS["documented"], 0)
    printed = np.array([np.abs(chain.azimuth_field(0, k)[250]) for k in range(9)]) ** 2
    offset = np.arange(9) * 2 * np.pi / 7200
    assert printed / printed[0] == pytest.approx(printed_gain(offset, BEAM) ** 4, rel=1e-4)  # power as G^4; complex64
    width = full_width(lambda t: PATTERNS["sinc2"].gain(t, 1.0) ** 2)
    assert (width, width * 3.9) == pytest.approx((0.7200, 2.808), abs=5e-4)  # half the last digit


def test_row_3_atmosphere() -> None:
    printed, corrected = (20 * np.log10(f(20_000.0, 0.01327)) for f in (printed_atmosphere, attenuation_amplitude))
    assert (printed, corrected) == pytest.approx((-1.06, -0.53), abs=5e-3)  # 0.53 dB two-way at 20 km, half the last digit


def test_row_4_power_of_incoherent_hits_with_range() -> None:
    # 1 m ball seen through a narrow box of rays: thousands of hits at 100 m, a quarter of them at 200 m
    box: dict[str, Any] = {"beamwidth_deg": 2, "beamwidth_el_deg": 2, "rays": 200_000, "range_max_m": 400}
    ball = [observed({"shape": "sphere", "radius_m": 1.0, "position_m": [0, r, 10]}, **box) for r in (100.0, 200.0)]
    counts = np.array([b.hits.range.size for b in ball])
    sigma_db = 10 / np.log(10) * np.sqrt(np.sum(1 / counts))
    free_of_the_beam = [np.sum(1 / (b.hits.range**2 + 1) ** 2) for b in ball]
    printed = 10 * np.log10(free_of_the_beam[0] / free_of_the_beam[1])
    # each hit weighed by the area it stands for, R^2 times the solid angle of a ray, which is the same for all
    weighed = [np.sum(b.hits.range**2 / b.hits.range**4) for b in ball]
    corrected = 10 * np.log10(weighed[0] / weighed[1])
    # 4 sigma of the counts; and the near side of the ball is 1 % nearer at 100 m: up to 0.2 dB
    assert printed == pytest.approx(60 * np.log10(2), abs=4 * sigma_db + 0.2)
    assert corrected == pytest.approx(40 * np.log10(2), abs=4 * sigma_db + 0.2)


def test_row_4_power_of_a_flat_facing_plate_with_range() -> None:
    box: dict[str, Any] = {"beamwidth_deg": 0.5, "beamwidth_el_deg": 0.5, "rays": 300_000, "range_max_m": 400}
    facing = {"shape": "plate", "width_m": 0.3, "height_m": 0.3, "heading_deg": 180}
    plate = [observed(facing | {"position_m": [0, r, 10]}, **box) for r in (100.0, 200.0)]
    counts = np.array([p.hits.range.size for p in plate])
    fields = [np.abs(np.sum(np.exp(1j * printed_phase(p.hits.range, LAMBDA)) / (p.hits.range**2 + 1))) for p in plate]
    printed = 20 * np.log10(fields[0] / fields[1])
    areas = [np.abs(np.sum(np.exp(1j * printed_phase(p.hits.range, LAMBDA)))) for p in plate]  # R^2 over R^2
    corrected = 20 * np.log10(areas[0] / areas[1])
    tolerance = 4 * 20 / np.log(10) * np.sqrt(np.sum(1 / counts)) + 0.05  # 4 sigma; the plate's near field at 100 m
    assert printed == pytest.approx(80 * np.log10(2), abs=tolerance)
    assert corrected == pytest.approx(40 * np.log10(2), abs=tolerance)


def test_row_4_a_small_target_far_out_is_missed_altogether() -> None:
    buoy = {"shape": "sphere", "radius_m": 1.0, "position_m": [0, 4900, 10]}
    expected = 2000 * np.pi / 4900**2 / (9 * BEAM * np.deg2rad(25))
    assert expected < 1e-3 and observed(buoy).hits.range.size == 0  # 2000 rays, seven hits in ten thousand azimuths
    assert received_amplitude(scene(buoy).radar, np.array([4900.0]))[0] > 0


def test_row_5_sign_and_phase_of_the_two_rays() -> None:
    assert printed_phase(100.001, LAMBDA) > printed_phase(100.0, LAMBDA)
    step = np.angle(two_way_phase(np.array([100.001]), LAMBDA) / two_way_phase(np.array([100.0]), LAMBDA))
    assert step == pytest.approx(-4 * np.pi * 0.001 / LAMBDA, abs=1e-9)  # rounding of phases of 4e4 rad
    position = (1000.0, 40.0, 10.0, LAMBDA)
    printed, corrected = np.abs(printed_two_ray_factor(*position)) ** 2, two_ray_factor(*position) ** 2
    assert np.abs(corrected) == pytest.approx(printed, rel=1e-12)  # a smooth flat sea: the same magnitude
    assert abs(np.angle(corrected)) > 0.1 and np.isreal(printed)  # the phase is what |F|^2 drops


def test_row_6_delays_rounded_to_a_sample() -> None:
    for rate, error_db in ((200e6, -23), (75e6, -15)):
        sent = chirp(pulse_times(PULSE, rate), BANDWIDTH, PULSE)
        weights = window("hamming", sent.size)
        positions = (100 + (np.arange(20) + 0.5) / 20) * SPEED_OF_LIGHT / (2 * rate)  # evenly over a sample
        wrong, whole = 0.0, 0.0
        for position in positions[:, None]:
            phase = printed_phase(position, LAMBDA)
            rounded = chirp_sum(sample_delay(position, rate), np.ones(1), phase, sent, 250)
            exact = exact_chirp_sum(position, np.ones(1), phase, BANDWIDTH, PULSE, rate, 250)
            right = compress(exact, sent, weights, 250)
            wrong += np.sum(np.abs(compress(rounded, sent, weights, 250) - right) ** 2)
            whole += np.sum(np.abs(right) ** 2)
        assert 10 * np.log10(wrong / whole) == pytest.approx(error_db, abs=0.5)  # half the last digit


def test_row_7_the_beam_twice() -> None:
    step = np.deg2rad(0.01)
    offset = np.arange(-2000, 2001) * step

    def degrees(power: np.ndarray) -> float:
        return float(np.rad2deg(sampled_width(power, step)))

    once = PATTERNS["sinc2"].gain(offset, BEAM) ** 2
    twice = beam_spread(once[:, None], BEAM, step)[:, 0]
    assert (degrees(once), degrees(twice)) == pytest.approx((2.81, 4.74), abs=6e-3)  # half the last digit and the grid
    printed = printed_two_way(offset, 0.0, BEAM, 1.0) ** 2
    blurred = beam_spread(printed[:, None], BEAM, step)[:, 0]
    assert (degrees(printed), degrees(blurred)) == pytest.approx((0.64, 3.95), abs=6e-3)


def test_row_8_the_mirrored_picture() -> None:
    for bearing_deg, read_as in ((30.0, 60.0), (45.0, 45.0), (120.0, -30.0), (250.0, -160.0)):
        bearing = np.array(np.deg2rad(bearing_deg))
        x, y, _ = printed_direction(bearing, np.array(0.0))
        assert np.rad2deg(np.arctan2(x, y)) == pytest.approx(read_as, abs=1e-9)  # read back by eqs. 21, 22; rounding
        x, y, _ = direction(bearing, np.array(0.0))
        assert np.rad2deg(np.arctan2(x, y)) % 360 == pytest.approx(bearing_deg, abs=1e-9)


def test_row_9_blind_range_of_one_antenna() -> None:
    assert SPEED_OF_LIGHT * PULSE / 2 == pytest.approx(1499, abs=0.5)  # half the last digit
    point = {"shape": "point", "rcs_dbsm": 0, "position_m": [0, 200, 10]}
    separate, shared = (
        np.abs(DocumentedEngine(scene(point, rays=1, eclipsing=on), PRESETS["documented"], 0).azimuth_field(0, 0)[100])
        for on in (False, True)
    )
    assert shared < 0.05 * separate  # 13 % of the pulse is received, under the foot of the Hamming window


def test_row_10_the_worked_example() -> None:
    degree = np.deg2rad(1.0)
    assert PATTERNS["sinc2"].gain(degree, BEAM) == pytest.approx(0.841, abs=5e-4)  # printed 0.67
    assert printed_gain(degree, BEAM) == pytest.approx(0.122, abs=5e-4)
    assert printed_two_way(degree, 0.0, BEAM, 1.0) == pytest.approx(0.0149, abs=5e-5)  # printed 0.20
    assert printed_phase(200.0, LAMBDA) == pytest.approx(78_888, abs=0.5)  # printed 78 873
    assert printed_phase(200.0, LAMBDA) / (2 * np.pi) == pytest.approx(12_555.35, abs=5e-3)  # printed 12 553


def test_the_worked_example_through_the_whole_chain() -> None:
    """One point at 200 m and 45 degrees, 200 MSPS: its delay, its bins, and amplitude and phase on boresight and a degree on."""
    assert 400 / SPEED_OF_LIGHT * 200e6 == pytest.approx(266.85, abs=5e-3)  # right: between two samples
    assert sample_delay(np.array([200.0]), 200e6).tolist() == [267]  # printed 267
    target = {"shape": "point", "rcs_dbsm": 0, "position_m": [200 * 0.5**0.5, 200 * 0.5**0.5, 10.0]}
    chain = DocumentedEngine(scene(target, sample_rate_hz=200e6, range_max_m=400, rays=1), PRESETS["documented"], seed=0)
    power = chain.scan(0)[1]
    assert np.argmax(power[90]) == 267 and np.argmax(power[:, 267]) == 90  # printed: 45 / 0.5 = 90th, counted from 0
    assert chain.range[[1, 267]] == pytest.approx(
        [0.7495, 200.11], abs=5e-3
    )  # printed 267 x 0.75 m = 200.25 m "about 200 m"
    boresight, one_degree_on = (chain.azimuth_field(0, index)[267] for index in (90, 92))
    assert np.abs(boresight) == pytest.approx(1 / (200.0**2 + 1), rel=1e-6)  # eq. 8 on boresight; complex64
    assert np.abs(one_degree_on) / np.abs(boresight) == pytest.approx(0.0149, abs=5e-5)  # eq. 3 on the amplitude
    turns = printed_phase(200.0, LAMBDA) / (2 * np.pi)
    assert np.angle(boresight) / (2 * np.pi) % 1 == pytest.approx(turns % 1, abs=1e-6)  # complex64


def test_row_11_the_pulse_under_a_hamming_window() -> None:
    rate = 32 * BANDWIDTH  # BT = 500
    sent = chirp(pulse_times(PULSE, rate), BANDWIDTH, PULSE)
    received = np.concatenate([sent, np.zeros(sent.size)])
    plain, weighed = (np.abs(compress(received, sent, window(name, sent.size), sent.size)) for name in ("none", "hamming"))
    widening = np.interp(-np.sqrt(0.5), -weighed[:64], np.arange(64)) / np.interp(-np.sqrt(0.5), -plain[:64], np.arange(64))
    assert widening == pytest.approx(1.47, abs=5e-3)  # half the last digit
    weights = window("hamming", sent.size)
    assert 10 * np.log10(np.mean(weights**2) / np.mean(weights) ** 2) == pytest.approx(1.34, abs=6e-3)
    middle = weighed[1:-1]
    sidelobes = 20 * np.log10(middle[(middle >= weighed[:-2]) & (middle > weighed[2:])])
    assert (sidelobes.max(), sidelobes[0]) == pytest.approx((-42.6, -43.3), abs=0.05)  # half the last digit
    unweighted = plain[1:-1][(plain[1:-1] >= plain[:-2]) & (plain[1:-1] > plain[2:])]
    assert 20 * np.log10(unweighted[0]) == pytest.approx(-13.2, abs=0.1)  # what eqs. 16 and 20 say


def test_row_12_millimetre_triangles() -> None:
    corner = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.75**0.5, 0.0]])
    origin, down = np.array([0.5e-3, 0.3e-3, 1.0]), np.array([[0.0, 0.0, -1.0]])
    for size, as_printed in ((1e-3, -1), (2e-3, 0)):
        face = np.array([[0, 1, 2]])
        assert TriangleList(size * corner, face, printed_crossings).first_hit(origin, down)[0] == as_printed
        assert TriangleList(size * corner, face, watertight_crossings).first_hit(origin, down)[0] == 0


def test_row_13_near_range() -> None:
    point = {"shape": "point", "rcs_dbsm": 0, "position_m": [0, 2, 10]}
    chain = observed(point, rays=1)
    assert chain.amplitudes[0] == pytest.approx(1 / (2.0**2 + 1), rel=1e-12)  # rounding
    radar = scene(point).radar
    amplitude = received_amplitude(radar, np.array([0.5, radar.range_min, 2.0]))
    assert amplitude / amplitude[1] == pytest.approx([1.0, 1.0, (radar.range_min / 2.0) ** 2], rel=1e-12)
