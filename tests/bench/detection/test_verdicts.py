"""Verdicts on detection, from counts that were made by hand or drawn."""

import numpy as np
import pytest
from scipy.stats import binomtest

from radar_service.bench.detection.detection import PFA, ScanDetection, spoke_gains
from radar_service.bench.detection.verdicts import (
    Measured,
    binomial_p,
    first_lost,
    judged,
    last_held,
    snr_difference_db,
    word,
)  # fmt: skip
from tests.bench.detection.test_detection import BUOY, radar_scene

PD = np.array([0.2, 0.5, 0.8])


def test_one_range_has_the_exact_binomial_test() -> None:
    """Twice the test of one range: two tests share the level."""
    p = binomtest(30, 40, 0.5).pvalue
    assert binomial_p(np.array([30]), 40, np.array([0.5])) == pytest.approx(2.0 * p)
    assert binomial_p(np.array([], dtype=int), 40, np.array([])) is None


def test_the_level_is_kept() -> None:
    """Of 100 draws that obey the law at most 5 % + 3 sigma have p below 0.05; the tests are conservative."""
    rng = np.random.default_rng(4)
    values = [binomial_p(rng.binomial(40, PD), 40, PD) for _ in range(100)]
    assert np.mean([value is not None and value < 0.05 for value in values]) < 0.05 + 3.0 * np.sqrt(0.05 * 0.95 / 100)


def test_a_shift_of_all_ranges_and_an_outlier_are_seen() -> None:
    pd = np.full(12, 0.5)
    shifted = binomial_p(np.full(12, 24), 40, pd)  # 60 % everywhere: no single range is conspicuous
    outlier = binomial_p(np.where(np.arange(12) == 3, 36, 20 - (np.arange(12) == 5)), 40, pd)
    assert shifted is not None and shifted < 1e-3 and 24 * binomtest(24, 40, 0.5).pvalue > 1.0
    assert outlier is not None and outlier < 1e-4
    assert binomial_p(np.full(12, 20), 40, pd) == 1.0


@pytest.mark.parametrize(
    ("p", "difference", "error", "expected"),
    [
        (0.5, 0.4, 0.1, "pass"),
        (0.001, 0.0, 0.1, "fail"),
        (0.5, -0.9, 0.1, "fail"),
        (0.5, 0.6, 0.1, "undecided, more scans"),
        (None, None, None, "no range to test"),
    ],
)
def test_words(p: float | None, difference: float | None, error: float | None, expected: str) -> None:
    assert word(p, difference, error) == expected


def test_first_lost_and_last_held_differ_where_there_are_nulls() -> None:
    distance, pd = np.arange(1.0, 7.0), np.array([1.0, 0.7, 0.9, 0.8, 0.5, 0.0])
    assert first_lost(distance, pd) == 2.0 and last_held(distance, pd) == 4.0
    assert first_lost(distance, np.ones(6)) is None and last_held(distance, np.zeros(6)) is None


def measured(shift_db: float, seed: int = 0, scans: int = 400) -> Measured:
    """Drawn detections of a steady target that is so many dB stronger than predicted."""
    radar, rng = radar_scene().radar, np.random.default_rng(seed)
    snr = 10.0 ** (np.arange(4.0, 14.0, 1.0) / 10.0)
    true = snr * 10.0 ** (shift_db / 10.0)
    pd = ScanDetection(spoke_gains(radar), 0, PFA).of(true)
    noise = (rng.standard_normal((scans, len(snr), 2)) @ [1.0, 1j]) / np.sqrt(2.0)
    value = np.abs(np.sqrt(true) + noise) ** 2 - 1.0
    distance = 1000.0 * 10.0 ** (np.arange(10) / 40.0)
    return Measured(distance[::-1], snr, scans, rng.binomial(scans, pd), value.sum(axis=0), (value**2).sum(axis=0))


def test_a_target_that_is_as_predicted_passes_and_others_do_not() -> None:
    made = radar_scene()
    verdicts = {shift: judged(made.radar, made.environment, BUOY, measured(shift)) for shift in (0.0, 1.5, -1.5)}
    assert {shift: one["word"] for shift, one in verdicts.items()} == {0.0: "pass", 1.5: "fail", -1.5: "fail"}
    for shift, one in verdicts.items():
        assert one["snr_difference_db"] == pytest.approx(shift, abs=4.0 * one["snr_error_db"]) and one["snr_error_db"] < 0.1
    row = verdicts[0.0]["ranges"][0]
    assert set(row) == {"range_m", "predicted", "detected", "eight_of_ten", "snr_db", "tested"} and row[
        "snr_db"
    ] == pytest.approx(4.0)
    assert len(verdicts[0.0]["curve"]["range_nm"]) == len(verdicts[0.0]["curve"]["predicted"]) >= 300


def test_an_snr_of_nothing_has_no_difference() -> None:
    silent = measured(0.0)
    assert snr_difference_db(silent, np.zeros(10, dtype=bool)) == (None, None)
