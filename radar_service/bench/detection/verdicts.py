"""Whether detection is what the radar equation predicts: exact binomial tests, the mean SNR, first-lost and last-held ranges."""

from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from scipy.stats import binom, binomtest

from radar_service.bench.detection.detection import (
    CRITERION,
    PFA,
    ScanDetection,
    Target,
    eight_of_ten,
    predicted_curve,
    spoke_gains,
)
from radar_service.numerics.constants import NAUTICAL_MILE
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.radar.parameters import Radar
from radar_service.world.environment import Environment

LOWEST, HIGHEST = 0.05, 0.95  # Pd of the ranges that are tested
SIGNIFICANCE = 0.001
SNR_LIMIT_DB = 0.5
SURE = 3.0  # standard errors
CURVE = 500  # points of a curve in a report, or up to twice as many


@dataclass(frozen=True)
class Measured:
    """What scans gave for a target at ranges (R,).

    distance: slant ranges [m], rising. predicted: SNR, a power ratio. scans: number. hits: detections. snr, square: sums over
    the scans of the measured SNR and of its square.
    """

    distance: Floats
    predicted: Floats
    scans: int
    hits: Indices
    snr: Floats
    square: Floats


def judged(radar: Radar, environment: Environment, target: Target, measured: Measured) -> dict[str, Any]:
    """Returns the verdict on a target with its ranges, as plain data."""
    pd = ScanDetection(spoke_gains(radar), target.swerling, PFA, radar.pulses_integrated).of(measured.predicted)
    tested = (pd > LOWEST) & (pd < HIGHEST)
    p = binomial_p(measured.hits[tested], measured.scans, pd[tested])
    difference, error = snr_difference_db(measured, tested)
    distance, curve = predicted_curve(radar, environment, target)
    share = measured.hits / measured.scans
    return {
        "target": target.name, "rcs_dbsm": target.rcs_dbsm, "swerling": target.swerling, "height_m": target.height,
        "standard_nm": target.standard_nm, "p": p, "snr_difference_db": difference, "snr_error_db": error,
        "word": word(p, difference, error),
        "first_lost_m": {"predicted": first_lost(distance, curve), "measured": first_lost(measured.distance, share)},
        "last_held_m": {"predicted": last_held(distance, curve), "measured": last_held(measured.distance, share)},
        "curve": _thinned(distance, curve), "ranges": _rows(measured, pd, tested),
    }  # fmt: skip


def _rows(measured: Measured, pd: Floats, tested: Flags) -> list[dict[str, Any]]:
    """One row a range."""
    columns = {
        "range_m": measured.distance, "predicted": pd, "detected": measured.hits / measured.scans,
        "eight_of_ten": eight_of_ten(pd), "snr_db": 10.0 * np.log10(measured.predicted), "tested": tested,
    }  # fmt: skip
    return [
        dict(zip(columns, row, strict=True)) for row in zip(*(column.tolist() for column in columns.values()), strict=True)
    ]


def _thinned(distance: Floats, pd: Floats) -> dict[str, list[float]]:
    """A predicted curve for figures."""
    every = max(1, len(pd) // CURVE)
    return {
        "range_nm": np.round(distance[::every] / NAUTICAL_MILE, 4).tolist(),
        "predicted": np.round(pd[::every], 4).tolist(),
    }


def binomial_p(hits: Indices, scans: int, pd: Floats) -> float | None:
    """Returns how likely hits (R,) of `scans` each are, or less likely ones, if detections have probabilities pd (R,).

    Two exact tests share the level: of the sum of all hits, which sees a shift, and of each range (Bonferroni), which sees a
    single one. None without ranges.
    """
    if not len(hits):
        return None
    single = min(float(binomtest(int(k), scans, float(p)).pvalue) for k, p in zip(hits, pd, strict=True))
    law = reduce(np.convolve, (binom.pmf(np.arange(scans + 1), scans, p) for p in pd))
    together = float(law[law <= law[int(hits.sum())] * (1.0 + 1e-7)].sum())
    return min(1.0, 2.0 * together, 2.0 * len(hits) * single)


def snr_difference_db(measured: Measured, tested: Flags) -> tuple[float | None, float | None]:
    """Returns the mean ratio of the measured SNR to the predicted one, and its standard error [dB]; None without ranges.

    tested: which ranges (R,).
    """
    mean = measured.snr / measured.scans
    error = np.sqrt(np.maximum(measured.square / measured.scans - mean**2, 0.0) / measured.scans)
    ratio, error = (mean / measured.predicted)[tested], (error / measured.predicted)[tested]
    if not len(ratio) or not ratio.mean() > 0.0:
        return None, None
    slope = 10.0 / np.log(10.0) / ratio.mean()
    return float(10.0 * np.log10(ratio.mean())), float(slope * np.sqrt((error**2).sum()) / len(error))


def word(p: float | None, difference: float | None, error: float | None) -> str:
    """Returns the verdict on a target."""
    if p is None or difference is None or error is None:
        return "no range to test"
    if p <= SIGNIFICANCE or abs(difference) - SURE * error > SNR_LIMIT_DB:
        return "fail"
    return "pass" if abs(difference) <= SNR_LIMIT_DB else "undecided, more scans"


def first_lost(distance: Floats, pd: Floats) -> float | None:
    """Returns the nearest of ranges (R,) whose Pd (R,) is below the criterion; None where there is none."""
    lost = distance[pd < CRITERION]
    return float(lost[0]) if len(lost) else None


def last_held(distance: Floats, pd: Floats) -> float | None:
    """Returns the farthest of ranges (R,) whose Pd (R,) meets the criterion; None where there is none."""
    held = distance[pd >= CRITERION]
    return float(held[-1]) if len(held) else None
