"""Thresholds: levels against slow loops, false alarms of receiver noise, ships among the reference cells."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.plots.thresholds import CellAveraging, KnownThreshold, OrderedStatistic
from radar_service.radar.parameters import Radar
from radar_service.receive.compression import receiver_noise_power
from tests.scenes import averaging, radar, scene

NOISY = {
    "azimuths": 512,
    "beamwidth_deg": 3,
    "range_max_m": 3000,
    "pulse_s": 1e-6,
    "bandwidth_hz": 20e6,
    "sample_rate_hz": 30e6,
}
CFARS = (CellAveraging, OrderedStatistic)


@pytest.fixture(scope="module", params=[1, 10])
def noise(request: pytest.FixtureRequest) -> tuple[Radar, np.ndarray]:
    """A radar that averages so many pulses, and the power (A, N) of 6 or 3 scans of its noise."""
    sim = rs.Simulator(scene(radar=averaging(NOISY, request.param), environment={"noise": True}), "balanced", seed=7)
    assert sim.scene.radar.pulses_integrated == request.param
    return sim.scene.radar, np.concatenate([sim.scan().power for _ in range(6 if request.param == 1 else 3)])


@pytest.mark.sample(5)
@pytest.mark.parametrize("pfa", [1e-3, 1e-4])
@pytest.mark.parametrize("make", [KnownThreshold, *CFARS])
def test_noise_gives_the_requested_false_alarms(make: Any, pfa: float, noise: tuple[Radar, np.ndarray]) -> None:
    """Within four standard errors; the error is that of whole spokes, as neighbouring cells exceed together."""
    settings, power = noise
    noise = power[: round(len(power) * 1e-4 / pfa)]  # as many alarms are to be expected of each rate
    alarms = (noise > make(settings, pfa).of(noise)).sum(axis=1)
    error = np.sqrt(max(alarms.var(ddof=1), alarms.mean()) / len(alarms))
    assert abs(alarms.mean() - pfa * noise.shape[1]) < 4 * error
    assert 4 * error < 0.5 * pfa * noise.shape[1]  # so that a factor for independent samples would be seen


@pytest.mark.parametrize("make", CFARS)
def test_levels_are_those_of_a_slow_loop(make: Any) -> None:
    """Each cell under test by itself: its windows beyond the guard, or one of twice the length near an end."""
    guard, side = 2, 5
    step = radar(**NOISY).range_step
    detector = make(radar(**NOISY), 1e-2, guard * step, side * step)
    power = np.random.default_rng(1).exponential(size=(70, 60)).astype(np.float32)
    threshold = detector.of(power)

    def level(row: np.ndarray, cell: int) -> float:
        left, right = np.arange(cell - guard - side, cell - guard), np.arange(cell + guard + 1, cell + guard + side + 1)
        if left[0] < 0:
            cells = cell + guard + 1 + np.arange(2 * side)
        elif right[-1] >= len(row):
            cells = cell - guard - 1 - np.arange(2 * side)
        else:
            cells = np.concatenate([left, right])
        return float(np.mean(row[cells]) if make is CellAveraging else np.sort(row[cells])[round(0.75 * 2 * side) - 1])

    slow = np.array([[level(row, cell) for cell in range(60)] for row in power[:3]])
    ratio = threshold[:3] / slow
    edge = guard + side
    assert np.ptp(ratio[:, edge:-edge]) < 1e-5 * ratio.max()  # single precision of the power
    ends = np.concatenate([ratio[:, :edge], ratio[:, -edge:]], axis=1)
    assert np.ptp(ends) < 1e-5 * ratio.max() and np.array_equal(detector.of(power[65:]), threshold[65:])


def test_a_ship_among_the_reference_cells_raises_a_mean_and_not_a_rank() -> None:
    power = np.full((1, 400), 1.0, dtype=np.float32)
    power[0, 230:240] = 1e4
    step = radar(**NOISY).range_step
    mean, ranked = (make(radar(**NOISY), 1e-4, 10 * step, 40 * step).of(power)[0, 200] for make in CFARS)
    assert mean > 1000 and ranked < 20


def test_the_guard_keeps_a_ship_out_of_its_own_level() -> None:
    power = np.full((1, 400), 1.0, dtype=np.float32)
    power[0, 190:211] = 1e4
    step = radar(**NOISY).range_step
    assert CellAveraging(radar(**NOISY), 1e-4, 21 * step, 40 * step).of(power)[0, 200] < 20


def test_a_known_threshold_is_the_same_everywhere() -> None:
    settings = radar(**NOISY)
    assert KnownThreshold(settings, 1e-4).of(np.ones((3, 4), np.float32)) == pytest.approx(
        receiver_noise_power(settings) * np.log(1e4)
    )


@pytest.mark.parametrize("make", [KnownThreshold, *CFARS])
@pytest.mark.parametrize("pfa", [0.0, 1.0, -1.0, float("nan")])
def test_a_probability_must_be_one(make: Any, pfa: float) -> None:
    with pytest.raises(ValueError, match="pfa: .* a probability between 0 and 1"):
        make(radar(**NOISY), pfa)


@pytest.mark.parametrize("make", CFARS)
def test_lengths_are_checked(make: Any) -> None:
    with pytest.raises(ValueError, match="guard: -1.0 is not allowed"):
        make(radar(**NOISY), 1e-4, -1.0)
    with pytest.raises(ValueError, match="window: inf is not allowed"):
        make(radar(**NOISY), 1e-4, 1.0, np.inf)
    with pytest.raises(ValueError, match="spokes have 50: set a shorter guard or window"):
        make(radar(**NOISY)).of(np.ones((2, 50), np.float32))
