"""Fluctuating targets through the whole engine: the distribution of their power, by chi-square."""

import numpy as np
import pytest
from scipy import stats

import radar_service as rs
from radar_service.scattering.swerling import Fluctuation
from tests.scenes import point, scene

LEVEL = 1e-4 / 4  # four cases, 1e-4 in all
CLASSES = 20  # equally likely under the law, 30 draws expected in each
RADAR = {"range_max_m": 600, "pulse_s": 1e-6, "azimuths": 16, "beamwidth_deg": 40}
LAWS = {"exponential": stats.expon(), "four degrees of freedom": stats.gamma(2, scale=0.5)}


def draws(case: int) -> np.ndarray:
    """600 independent powers relative to steady targets: of three that are more than a pulse apart one a scan for the slow cases,
    three azimuths of each scan, all within 10 dB of the peak, for the fast ones."""
    ranges = (200.0, 380.0, 560.0)
    steady, sim = (
        rs.Simulator(scene([point(f"{north}", 0, north, swerling=each) for north in ranges], radar=RADAR), seed=11)
        for each in (0, case)
    )
    scan, rows = steady.scan(), [0] if case in (1, 3) else [0, 1, 15]
    cells = np.ix_(rows, [int(np.abs(scan.range - north).argmin()) for north in ranges])
    power = scan.power[cells]
    assert (power > 0.1 * power[0]).all()
    return np.concatenate([(sim.scan().power[cells] / power).ravel() for _ in range(200 // len(rows) + 1)])[:600]


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


def factors(names: str, wanted: str, scene_name: str = "test", seed: int = 1, radar: str = "", case: int = 2) -> list[float]:
    """Factors of one body among others over 40 azimuths of ten scans of four."""
    bodies = scene([point(name, 100.0 + 50 * k, 400, swerling=case) for k, name in enumerate(names)]).bodies
    weight = np.ones((1, 40), dtype=np.float32)
    body = np.array([names.index(wanted)])
    Fluctuation(bodies, scene_name, 4, seed, radar).apply(weight, np.arange(40), np.array([1.0]), body)
    return weight[0].tolist()


@pytest.mark.parametrize("case", [1, 2, 3, 4])
def test_draws_depend_on_names_and_the_seed_alone(case: int) -> None:
    """Other bodies, and their order, change no draw; another body, scene, radar or seed changes them."""
    alone = factors("b", "b", case=case)
    assert len(set(alone)) > 5
    for names in ("ab", "ba", "cab", "bca"):
        assert factors(names, "b", case=case) == alone
    assert factors("ab", "a", case=case) != alone
    assert factors("b", "b", scene_name="other", case=case) != alone
    assert factors("b", "b", radar="second", case=case) != alone
    assert factors("b", "b", seed=2, case=case) != alone


def test_many_echoes_at_once_have_the_factors_of_each() -> None:
    """Two echoes of each of ten bodies of all cases, in any order, over 40 azimuths of two scans."""
    bodies = scene([point(str(b), 100.0 + 50 * b, 400, swerling=b % 5) for b in range(10)]).bodies
    rng, number = np.random.default_rng(3), np.arange(40)
    body, drawn = rng.permutation(np.repeat(np.arange(10), 2)), Fluctuation(bodies, "test", 20, 1)
    azimuth, weight = 0.6 * body, np.ones((20, 40), dtype=np.float32)
    drawn.apply(weight, number, azimuth, body)
    for e in range(20):
        each = [np.ones((1, 1), dtype=np.float32) for _ in number]
        for n, one in zip(number, each, strict=True):
            Fluctuation(bodies, "test", 20, 1).apply(one, np.array([n]), azimuth[e : e + 1], body[e : e + 1])
        assert weight[e].tolist() == [float(one[0, 0]) for one in each]
    assert (weight[body % 5 == 0] == 1.0).all() and len(np.unique(weight[body % 5 > 0])) > 100


def test_a_body_put_into_a_scene_changes_no_echo_of_another() -> None:
    """Fields around a fluctuating hull and a wooden box are the same, whatever stands before them in the file."""
    box = {"shape": "box", "length_m": 30, "width_m": 9, "height_m": 6}
    wood = {**box, "name": "w", "material": "wood", "position_m": [0, 450, 0]}
    hull = {**box, "name": "h", "rcs_dbsm": 20, "swerling": 1, "position_m": [450, 0, 0]}
    radar = {"range_max_m": 600, "pulse_s": 1e-7, "azimuths": 64, "beamwidth_deg": 10}
    plain = rs.Simulator(scene([wood, hull], radar=radar)).scan().field
    more = rs.Simulator(scene([point("new", 100, 100, 15, -90, swerling=1), hull, wood], radar=radar)).scan().field
    far = np.abs(plain) > 1e-3 * np.abs(plain).max()
    assert far.sum() > 50
    np.testing.assert_allclose(more[far], plain[far], rtol=2e-3)  # single precision, and a point 110 dB below
