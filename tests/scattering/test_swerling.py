"""Fluctuating targets through the whole engine: the distribution of their power, by chi-square."""

import numpy as np
import pytest
from scipy import stats

import radar_service as rs
from tests.scenes import point, scene

LEVEL = 1e-4 / 4  # four cases, 1e-4 in all
CLASSES = 20  # equally likely under the law, 30 draws expected in each
RADAR = {"range_max_m": 600, "pulse_s": 1e-6, "azimuths": 16, "beamwidth_deg": 40}
LAWS = {"exponential": stats.expon(), "four degrees of freedom": stats.gamma(2, scale=0.5)}


def draws(case: int) -> np.ndarray:
    """600 independent powers relative to a steady target: one a scan for the slow cases, three azimuths of each scan, all
    within 10 dB of the peak, for the fast ones."""
    steady = rs.Simulator(scene([point("t", 0, 500)], radar=RADAR)).scan().power
    column = int(np.argmax(steady[0]))
    rows = [0] if case in (1, 3) else [0, 1, 15]
    assert all(steady[row, column] > 0.1 * steady[0, column] for row in rows)
    sim = rs.Simulator(scene([point("t", 0, 500, swerling=case)], radar=RADAR), seed=11)
    taken = [sim.scan().power[rows, column] / steady[rows, column] for _ in range(600 // len(rows))]
    return np.concatenate(taken)


def chi_square(powers: np.ndarray, law: stats.rv_continuous) -> float:
    """The level at which powers would just be refused as draws of the law."""
    counts = np.bincount((law.cdf(powers) * CLASSES).astype(int).clip(0, CLASSES - 1), minlength=CLASSES)
    return float(stats.chisquare(counts).pvalue)


@pytest.mark.parametrize("case", [1, 2, 3, 4])
def test_power_follows_its_law_and_not_the_other(case: int) -> None:
    """Cases 1 and 2 exponential, 3 and 4 chi-square with four degrees of freedom (Swerling 1960); the other law is refused
    by the same draws, so the test has the power to tell them apart."""
    right, wrong = LAWS.values() if case in (1, 2) else reversed(LAWS.values())
    powers = draws(case)
    assert len(powers) == 600
    assert chi_square(powers, right) > LEVEL
    assert chi_square(powers, wrong) < LEVEL
