"""What sensors report, against the truth and the laws, to rounding."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.errors.sensors import (
    BLOCK,
    EAST,
    GYRO,
    LOG,
    NORTH,
    SINUSOIDS,
    SensorLaws,
    SensorNoise,
    antenna_error,
    backlash,
    draws,
    is_lost,
)
from radar_service.numerics.frames import wrap_angle, wrap_bearing
from radar_service.numerics.types import Floats, Indices
from radar_service.records.reports import Readings
from radar_service.world.reporting import AntennaErrors
from tests.errors.runs import AZIMUTHS, SCENE, same, simulator, whole

DEGREE, KNOT = np.pi / 180.0, 1852 / 3600
ROUNDING = 1e-12  # rad, m or m/s: some operations on numbers below 1000


def true(errors: Any, scans: int = 1) -> tuple[Any, Readings, Indices, Floats]:
    """The reported block of a run, its true readings, numbers and times."""
    block = whole(simulator(errors), scans)
    assert block.true is not None
    return block, block.true, block.first + np.arange(len(block)), block.time


def test_the_truth_is_that_of_a_run_without_errors() -> None:
    block, readings, _, _ = true({"profile": "imo-a823", "position": {"noise_m": 5}})
    plain = whole(simulator())
    for value, expected in zip(readings, plain.readings, strict=True):
        np.testing.assert_array_equal(value, expected)
    np.testing.assert_array_equal(block.field, plain.field)
    np.testing.assert_array_equal(block.power, plain.power)
    assert plain.true is None and not same(block, plain)


def test_a_gyro_turns_heading_course_and_azimuth_together() -> None:
    gyro = {"bias_deg": 1.5, "calibration_deg": 0.7, "calibration_phase_deg": 30, "noise_deg": 0.2, "noise_time_s": 2}
    block, was, number, time = true({"gyro": gyro}, scans=3)
    expected = 1.5 * DEGREE + 0.7 * DEGREE * np.sin(was.heading - 30 * DEGREE)
    expected += 0.2 * DEGREE * SensorNoise(2.0, 5, GYRO).at(number, time)
    assert np.ptp(was.heading) > 0.5  # the ship turns
    for reported, truly in ((block.heading, was.heading), (block.course, was.course), (block.azimuth, was.azimuth)):
        np.testing.assert_allclose(wrap_angle(reported - truly), expected, atol=ROUNDING)
        assert reported.min() >= 0.0 and reported.max() < 2.0 * np.pi
    np.testing.assert_array_equal(block.position, was.position)
    np.testing.assert_array_equal(block.speed, was.speed)


def test_a_log_has_bias_scale_and_noise() -> None:
    block, was, number, time = true({"log": {"bias_kn": 0.5, "scale_percent": 3, "noise_kn": 0.1, "noise_time_s": 4}})
    expected = was.speed * 1.03 + 0.5 * KNOT + 0.1 * KNOT * SensorNoise(4.0, 5, LOG).at(number, time)
    np.testing.assert_allclose(block.speed, expected, atol=ROUNDING)
    np.testing.assert_array_equal(block.heading, was.heading)
    np.testing.assert_array_equal(block.azimuth, was.azimuth)


@pytest.mark.parametrize(("percent", "least_kn", "sign"), [(2.0, 50.0, 1.0), (-2.0, 50.0, -1.0), (2.0, 0.01, 0.0)])
def test_a_log_errs_by_a_share_of_the_speed_or_by_the_least(percent: float, least_kn: float, sign: float) -> None:
    """50 knots are more than 2 % of any speed here, and 0.01 knots are less; its sign is that of the share."""
    block, was, _, _ = true({"log": {"scale_percent": percent, "least_kn": least_kn}})
    expected = was.speed * 1.02 if sign == 0.0 else was.speed + sign * 50.0 * KNOT
    np.testing.assert_allclose(block.speed, expected, atol=ROUNDING)


def test_a_position_has_bias_and_noise_of_each_axis() -> None:
    block, was, number, time = true({"position": {"bias_m": [3, -4], "noise_m": 2, "noise_time_s": 30}})
    for axis, (bias, key) in enumerate(((3.0, EAST), (-4.0, NORTH))):
        expected = bias + 2.0 * SensorNoise(30.0, 5, key).at(number, time)
        np.testing.assert_allclose(block.position[:, axis] - was.position[:, axis], expected, atol=1e-10)  # of 200 m


def test_latency_reports_the_readings_of_an_older_spoke() -> None:
    period = 1.0 / AZIMUTHS
    errors = {"gyro": {"latency_s": 10.2 * period}, "log": {"latency_s": 20 * period}, "position": {"latency_s": 5 * period}}
    block, was, _, _ = true(errors, scans=3)
    for reported, truly, spokes in (
        (block.heading, was.heading, 10), (block.course, was.course, 10), (block.speed, was.speed, 20),
        (block.position, was.position, 5),
    ):  # fmt: skip
        np.testing.assert_allclose(reported[spokes:], truly[:-spokes], atol=ROUNDING)
        np.testing.assert_allclose(reported[:spokes], np.broadcast_to(truly[0], reported[:spokes].shape), atol=ROUNDING)
    np.testing.assert_allclose(
        wrap_angle(block.azimuth - was.azimuth), wrap_angle(block.heading - was.heading), atol=ROUNDING
    )


def test_the_antenna_errs_in_azimuth_alone() -> None:
    block, was, _, _ = true({"antenna": {"misalignment_deg": -2, "encoder_step_deg": 5}})
    step, from_bow = 5 * DEGREE, wrap_angle(was.azimuth - was.heading)
    expected = np.rint((from_bow - 2 * DEGREE) / step) * step - from_bow
    np.testing.assert_allclose(wrap_angle(block.azimuth - was.azimuth), expected, atol=ROUNDING)
    np.testing.assert_array_equal(block.heading, was.heading)


def test_without_a_heading_azimuths_count_from_the_bow() -> None:
    block, was, _, time = true(
        {"gyro": {"bias_deg": 3}, "antenna": {"misalignment_deg": 1}, "feed": {"heading_lost_s": [[0.25, 0.5]]}}
    )
    lost = (time >= 0.25) & (time < 0.5)
    assert 0 < lost.sum() < AZIMUTHS
    np.testing.assert_array_equal(np.isnan(block.heading), lost)
    np.testing.assert_array_equal(np.isnan(block.course), lost)
    expected = wrap_bearing(was.azimuth + 4 * DEGREE - np.where(lost, was.heading + 3 * DEGREE, 0.0))
    np.testing.assert_allclose(block.azimuth, expected, atol=ROUNDING)
    np.testing.assert_array_equal(is_lost(np.array([0.9, 1.0, 2.0]), ((1.0, 2.0), (5.0, 6.0))), [False, True, False])


@pytest.mark.parametrize("scan", [1, 4])
def test_a_run_from_a_later_scan_reports_the_same(scan: int) -> None:
    errors = {"profile": "imo-a823", "gyro": {"latency_s": 0.3}, "position": {"noise_m": 5, "latency_s": 0.2}}
    through, later = simulator(errors), simulator(errors)
    list(through.blocks(scan, size=7))
    later.skip_to(scan)
    assert same(whole(through), whole(later)) and not same(whole(through), whole(simulator(errors, seed=6)))


def test_radars_of_one_ship_share_its_sensors_and_have_antennas_of_their_own() -> None:
    scene = rs.load_scene(SCENE | {"errors": {"profile": "imo-a823"}})
    number, plain = np.arange(AZIMUTHS), whole(simulator())
    assert scene.errors is not None
    one, other = (
        SensorLaws(scene.errors, scene.radar, 5, key).reported(number, plain.time, plain.readings, lambda _: plain.readings)
        for key in (0, 9)
    )
    np.testing.assert_array_equal(one.heading, other.heading)
    np.testing.assert_array_equal(one.speed, other.speed)
    assert (one.azimuth != other.azimuth).any()


def test_own_ship_at_anchor_keeps_its_reports_apart_from_the_echoes() -> None:
    """A resting antenna takes another way through the engine."""
    still = SCENE | {"own_ship": {"heading_deg": 350}}
    block = whole(simulator({"gyro": {"bias_deg": 20}}, **{"own_ship": still["own_ship"]}))
    np.testing.assert_allclose(block.heading, 10 * DEGREE, atol=ROUNDING)
    assert np.all(block.heading == block.heading[0])


ANGLES = np.linspace(-np.pi, np.pi, 4000, endpoint=False)
NUMBER = np.arange(len(ANGLES))


def error(misalignment: float = 0.0, play: float = 0.0, noise: float = 0.0, step: float = 0.0) -> Floats:
    """The errors at ANGLES."""
    return antenna_error(AntennaErrors(misalignment, play, noise, step), SensorNoise(0.0, 3, 1).at(NUMBER, ANGLES), ANGLES)


def test_play_is_zero_along_and_across_the_wind_and_evenly_distributed() -> None:
    """It changes its sign four times a turn."""
    quarter = np.pi / 2.0
    np.testing.assert_allclose(backlash(quarter * np.arange(4)), 0.0, atol=1e-15)  # rounding of sin(2 pi)
    np.testing.assert_allclose(backlash(quarter * (np.arange(4) + 0.5)), [1, -1, 1, -1], atol=1e-7)  # arcsin near 1
    counts, _ = np.histogram(error(play=0.05), 10, (-0.05, 0.05))
    assert np.abs(counts - len(ANGLES) / 10).max() <= 4  # four sides of the triangle wave, one sample at each end


def test_the_encoder_rounds_the_angle_from_the_bow_to_whole_steps() -> None:
    step = 0.2 * np.pi / 180.0
    angle = ANGLES + error(misalignment=0.01, step=step)
    np.testing.assert_allclose(angle / step, np.rint(angle / step), atol=1e-9)  # rounding of 900 steps
    assert np.abs(error(step=step)).max() <= step / 2.0 * (1.0 + 1e-9)


def test_the_encoder_is_noisy() -> None:
    values = error(noise=0.01)
    assert values.std() == pytest.approx(0.01, rel=4.4 / np.sqrt(2.0 * len(ANGLES)))  # 4.4 standard errors: level 1e-5
    assert abs(values.mean()) < 4.4 * 0.01 / np.sqrt(len(ANGLES))


# Noise of sensors against its law. Seeds are fixed; bounds are 4.4 standard errors, a level of 1e-5 for each.
SEEDS, SIGMAS = 3000, 4.4
TIME = 30.0  # s, the correlation time
LAGS = TIME * np.array([0.0, 0.5, 1.0, 2.0])


def test_mean_deviation_and_correlation_over_many_seeds() -> None:
    start = 1234.5
    values = np.array([SensorNoise(TIME, seed, 1).at(np.zeros(4, dtype=np.int64), start + LAGS) for seed in range(SEEDS)])
    assert np.abs(values.mean(axis=0)).max() < SIGMAS / np.sqrt(SEEDS)
    kurtosis = 3.0 - 1.5 / SINUSOIDS
    assert np.abs(np.mean(values**2, axis=0) - 1.0).max() < SIGMAS * np.sqrt((kurtosis - 1.0) / SEEDS)
    correlation = np.mean(values[:, :1] * values, axis=0)
    expected = np.exp(-LAGS / TIME)
    error = SIGMAS * np.sqrt((1.0 + expected**2) / SEEDS)  # of the product of two normal numbers
    assert (np.abs(correlation - expected) < error).all()


def test_a_single_run_has_the_deviation_and_the_correlation_time_too() -> None:
    """Over 2000 correlation times; frequencies are one in each of equal shares, which leaves less than 0.05 of either."""
    step = TIME / 10.0
    values = SensorNoise(TIME, 5, 1).at(np.zeros(20_000, dtype=np.int64), step * np.arange(20_000))
    assert abs(values.mean()) < 0.05 and values.std() == pytest.approx(1.0, abs=0.05)
    assert np.mean(values[:-10] * values[10:]) == pytest.approx(np.exp(-1.0), abs=0.05)


def test_noise_is_a_function_of_time() -> None:
    noise, number = SensorNoise(TIME, 5, 1), np.arange(100)
    whole = noise.at(number, 0.1 * number)
    np.testing.assert_array_equal(SensorNoise(TIME, 5, 1).at(number[40:], 0.1 * number[40:]), whole[40:])
    for other in (SensorNoise(TIME, 6, 1), SensorNoise(TIME, 5, 2)):
        assert abs(np.mean(other.at(number, 40.0 * number) * noise.at(number, 40.0 * number))) < SIGMAS / np.sqrt(100)


def test_without_a_correlation_time_spokes_are_independent() -> None:
    number = np.arange(50_000)
    values = SensorNoise(0.0, 5, 1).at(number, np.zeros(50_000))
    assert abs(values.mean()) < SIGMAS / np.sqrt(50_000)
    assert abs(np.mean(values**2) - 1.0) < SIGMAS * np.sqrt(2.0 / 50_000)
    assert abs(np.mean(values[1:] * values[:-1])) < SIGMAS / np.sqrt(50_000)
    some = np.array([BLOCK - 1, BLOCK, 7, 40_000])
    np.testing.assert_array_equal(SensorNoise(0.0, 5, 1).at(some, np.zeros(4)), values[some])


def test_uniform_draws_are_even_and_belong_to_their_spoke() -> None:
    values = draws(np.arange(20_000), 2, 9, 4)
    assert values.min() >= 0.0 and values.max() < 1.0
    counts = np.stack([np.histogram(column, 20, (0.0, 1.0))[0] for column in values.T])
    chi_square = ((counts - 1000.0) ** 2 / 1000.0).sum(axis=1)
    assert chi_square.max() < 57.0  # chi-square of 19 degrees of freedom at a level of 1e-5
    np.testing.assert_array_equal(draws(np.array([300, 5]), 2, 9, 4), values[[300, 5]])
