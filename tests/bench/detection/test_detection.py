"""Probability of detection against closed forms, and the radar equation against the one printed in textbooks."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.detection.detection import (
    ScanDetection,
    Target,
    drawn_powers,
    eight_of_ten,
    ground_distance,
    predicted_curve,
    signal_to_noise,
    spoke_gains,
    steady_detection,
)  # fmt: skip
from radar_service.receive.compression import receiver_noise_power
from radar_service.world.scene import Scene
from tests.scenes import scene

PFA = 1e-4
LEVEL = -np.log(PFA)
SNR = 10.0 ** (np.arange(0.0, 28.0, 1.5) / 10.0)
CLOSED = {  # Pd of one cell of one spoke (Swerling 1960; Skolnik 2001, 2.8)
    1: PFA ** (1.0 / (1.0 + SNR)),
    3: np.exp(-LEVEL / (1.0 + SNR / 2.0)) * (1.0 + LEVEL * (SNR / 2.0) / (1.0 + SNR / 2.0) ** 2),
}
BUOY = Target("buoy", 3.5, 10.0, 0, 4.9)


def radar_scene(**air: object) -> Scene:
    """A plain pulse of X band with a beam of 2 degrees."""
    return scene(
        radar={
            "azimuths": 360,
            "beamwidth_deg": 2.0,
            "range_max_m": 8000,
            "modulation": "none",
            "pulse_s": 2.5e-7,
            "power_w": 1000,
        },
        environment={"noise": True, **air},
    )


@pytest.mark.parametrize("case", [1, 2, 3, 4])
def test_a_single_spoke_has_the_closed_form(case: int) -> None:
    """Within 1e-3 of what equally probable draws err by."""
    assert ScanDetection(np.ones(1), case, PFA).of(SNR) == pytest.approx(CLOSED[case if case % 2 else case - 1], abs=1e-3)


def test_a_steady_target_is_detected_as_drawn_noise_says() -> None:
    """200 000 draws: four standard deviations are 0.0045."""
    rng = np.random.default_rng(1)
    noise = (rng.standard_normal((200_000, 2)) @ [1.0, 1j]) / np.sqrt(2.0)
    for snr in (2.0, 6.0, 10.0):
        share = float((np.abs(np.sqrt(snr) + noise) ** 2 > LEVEL).mean())
        assert steady_detection(np.array(snr), PFA) == pytest.approx(share, abs=0.0045)
    assert steady_detection(np.array(0.0), PFA) == pytest.approx(PFA)


@pytest.mark.parametrize("pulses", [5, 10])
def test_averaged_pulses_are_detected_as_much_farther_as_albersheim_has_it(pulses: int) -> None:
    """His formula (1981), good to 0.2 dB: a Pd of 0.8 needs 5.3 dB less with 5 pulses, 7.9 dB less with 10."""

    def needed_db(looks: int) -> float:
        a, b = np.log(0.62 / PFA), np.log(0.8 / 0.2)
        return float(-5.0 * np.log10(looks) + (6.2 + 4.54 / np.sqrt(looks + 0.44)) * np.log10(a + 0.12 * a * b + 1.7 * b))

    snr_db = np.arange(-10.0, 20.0, 0.01)
    for looks in (1, pulses):
        pd = steady_detection(10.0 ** (snr_db / 10.0), PFA, looks)
        assert np.interp(0.8, pd, snr_db) == pytest.approx(needed_db(looks), abs=0.2)


@pytest.mark.parametrize("case", [0, 1, 2])
def test_several_spokes_detect_what_one_of_them_does(case: int) -> None:
    """Drawn: case 1 with one power for all spokes, case 2 with one for each."""
    rng, gain, snr, count = np.random.default_rng(case), np.array([0.6, 1.0, 0.6]), 8.0, 40_000
    power = {0: np.ones((count, 1)), 1: rng.exponential(size=(count, 1)), 2: rng.exponential(size=(count, 3))}[case]
    noise = (rng.standard_normal((count, 3, 2)) @ [1.0, 1j]) / np.sqrt(2.0)
    share = float((np.abs(np.sqrt(snr * gain * power) + noise) ** 2 > LEVEL).any(axis=1).mean())
    assert float(ScanDetection(gain, case, PFA).of(np.array(snr))) == pytest.approx(
        share, abs=0.01
    )  # four standard deviations


def test_draws_have_mean_one_and_the_variance_of_their_law() -> None:
    assert drawn_powers(0).tolist() == [1.0]
    for case, variance in ((1, 1.0), (2, 1.0), (3, 0.5), (4, 0.5)):
        power = drawn_powers(case)
        assert power.mean() == pytest.approx(1.0, abs=0.005) and power.var() == pytest.approx(variance, abs=0.05)


def test_the_criterion() -> None:
    """Pd 0.8 per scan: 8 of 10 scans in 68 % of cases."""
    assert float(eight_of_ten(np.array(0.8))) == pytest.approx(0.678, abs=5e-4)
    assert eight_of_ten(np.array([0.0, 1.0])).tolist() == [0.0, 1.0]


def test_the_radar_equation_as_printed() -> None:
    """P = Pt G^2 lambda^2 sigma / ((4 pi)^3 R^4), target as high as the antenna over a flat earth."""
    made = radar_scene(earth="flat")
    radar, wavelength = made.radar, 299_792_458.0 / 9.41e9
    level = replace(BUOY, height=radar.height)
    power = 1000.0 * 1000.0**2 * wavelength**2 * 10.0 / ((4.0 * np.pi) ** 3 * 3000.0**4)
    snr = signal_to_noise(radar, made.environment, np.array([3000.0]), level)
    assert snr == pytest.approx(power / receiver_noise_power(radar), rel=1e-6)


def test_over_the_sea_there_are_lobes_and_nulls() -> None:
    """F^4 between 0 and 16 times free space, whose peaks lie near where the paths differ by odd halves of a wavelength."""
    free, sea = radar_scene(), radar_scene(multipath=True)
    ground = np.linspace(1000.0, 7000.0, 4000)
    factor = signal_to_noise(sea.radar, sea.environment, ground, BUOY) / signal_to_noise(
        free.radar, free.environment, ground, BUOY
    )
    assert factor.min() < 0.01 and 10.0 < factor.max() < 16.0
    null = ground[np.argmin(np.where(ground > 2000.0, factor, np.inf))]
    assert 2.0 * 15.0 * 3.5 / null == pytest.approx(299_792_458.0 / 9.41e9, rel=0.1)  # the path differs by a wavelength


def test_beyond_the_horizon_there_is_nothing() -> None:
    made = radar_scene()
    horizon = 4121.0 * (np.sqrt(15.0) + np.sqrt(3.5))  # sqrt(2 4/3 6371 km) = 4121 m per root of a metre
    near, far = signal_to_noise(made.radar, made.environment, np.array([horizon - 50.0, horizon + 50.0]), BUOY)
    assert near > 0.0 and far == 0.0


def test_a_slant_range_and_its_distance_along_the_earth() -> None:
    made = radar_scene()
    (ground,) = ground_distance(np.array([5000.0]), 3.5, made.radar, made.environment)
    z = 3.5 - 15.0 - ground**2 / (2.0 * 4.0 / 3.0 * 6_371_000.0)
    assert np.hypot(ground, z) == pytest.approx(5000.0, abs=1e-9)


def test_the_curve_of_a_target_falls_with_range() -> None:
    made = radar_scene()
    distance, pd = predicted_curve(made.radar, made.environment, replace(BUOY, rcs_dbsm=-8.0))
    assert (np.diff(pd) <= 1e-6).all() and pd[0] > 0.999 and pd[-1] < 0.2
    assert ((distance / made.radar.range_step) % 1.0 == pytest.approx(0.5)) and len(spoke_gains(made.radar)) == 3
