"""The video chain: exact levels by theory, the peak-keeping reduction against a plain loop."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import radar_service as rs
from radar_service.display.video import (
    DB_PER_STEP,
    MARGIN_DB,
    Controls,
    clutter_level,
    decibels,
    display_video,
    layout,
    noise_threshold_db,
    peaks,
    rain_level_db,
    sea_attenuation_db,
    strongest,
)
from tests.scenes import point, scene

NOISE = 1.371e-15  # W, the receiver of docs/conventions.md
HALF_STEP = DB_PER_STEP / 2 + 1e-5  # a byte is the nearest step; float32 logarithms of -150 dB err by 1e-5 dB


def cells(*levels_db: float) -> np.ndarray:
    """One spoke of power [W] at these levels above the noise threshold [dB]."""
    level = np.array(levels_db) + noise_threshold_db(NOISE)
    return (10.0 ** (level / 10.0)).astype(np.float32)[None, :]


def shown(power: np.ndarray, **by_hand: float) -> np.ndarray:
    to = layout(power.shape[1], 5.0, 10.0)
    return display_video(power, to, Controls(**({"gain": 50.0} | by_hand), gain_auto=False, sea_auto=False), NOISE)


@settings(deadline=None, max_examples=60)
@given(samples=st.integers(1, 400), requested=st.integers(1, 500))
def test_every_cell_goes_to_the_bin_of_its_centre(samples: int, requested: int) -> None:
    to = layout(samples, 5.0, 10.0, requested)
    spoke = np.random.default_rng(samples).random((2, samples))
    expected = np.zeros((2, to.bins))
    for n in range(samples):  # in whole numbers: floor((n + 1/2) B / N)
        b = (2 * n + 1) * to.bins // (2 * samples)
        expected[:, b] = np.maximum(expected[:, b], spoke[:, n])
    assert to.bins == min(samples, requested)
    np.testing.assert_array_equal(peaks(spoke, to), expected)


def test_bins_stand_in_the_middle_of_their_cells() -> None:
    to = layout(20, 5.0, 10.0, 5)
    assert (to.step, to.first, to.range) == (40.0, 20.0, 200.0)
    printed = layout(20, 0.0, 10.0, 5)  # samples at n step, as the specification prints it
    assert (printed.first, printed.range) == (15.0, 195.0)


@pytest.mark.parametrize(("reach", "samples"), [(200.0, 20), (100.0, 10), (101.0, 11), (3.0, 1), (1e6, 20), (None, 20)])
def test_range_crops_the_cells_that_begin_beyond_it(reach: float | None, samples: int) -> None:
    assert layout(20, 5.0, 10.0, None, reach).samples == samples


@pytest.mark.parametrize("reach", [0.0, -5.0, math.nan])
def test_a_range_that_is_not_positive_is_refused(reach: float) -> None:
    with pytest.raises(ValueError, match="range"):
        layout(20, 5.0, 10.0, None, reach)


def test_no_bins_are_refused() -> None:
    with pytest.raises(ValueError, match="bins: 0"):
        layout(20, 5.0, 10.0, 0)


def test_the_strongest_sample_keeps_its_phase() -> None:
    field = np.array([[1, 2j, -3, 1, 1j, 0, -5j]], dtype=np.complex64)
    np.testing.assert_array_equal(strongest(field, layout(7, 5.0, 10.0, 3)), [[2j, -3, -5j]])


def test_noise_passes_the_threshold_at_the_stated_rate() -> None:
    cells_total = 1_000_000
    noise = np.random.default_rng(1).exponential(NOISE, (100, cells_total // 100)).astype(np.float32)
    rate = np.mean(10 * np.log10(noise) > noise_threshold_db(NOISE))
    five_sigma = 5 * math.sqrt(1e-4 / cells_total)
    assert abs(rate - 1e-4) < five_sigma
    assert abs(np.mean(shown(noise) > 0) - 1e-4) < five_sigma


@pytest.mark.parametrize("gain", [42.0, 50.0, 65.0])
def test_a_cell_shows_exactly_from_the_threshold_on(gain: float) -> None:
    """Where the exponential law leaves 1e-4 of the noise at gain 50; to 1e-4 dB, ten float32 roundings of -150 dB, which is
    a thousandth of that probability."""
    edge = 50.0 - gain
    np.testing.assert_array_equal(shown(cells(edge - 1e-4, edge + 1e-4, edge + DB_PER_STEP + 1e-4), gain=gain)[0], [0, 1, 2])


def test_bytes_count_steps_above_the_threshold() -> None:
    levels = np.array([-20.0, 0.01, 1.0, 20.0, 63.0, 200.0])
    got = shown(cells(*levels))[0]
    assert (got[0], got[-1]) == (0, 255)
    above = (got[1:-1] - 0.5) * DB_PER_STEP  # the middle of a step
    np.testing.assert_allclose(above, levels[1:-1], atol=HALF_STEP)


def test_gain_is_a_decibel_per_percent() -> None:
    expected = 30.0 + np.array([-20.0, 0.0, 15.0])
    got = [shown(cells(30.0), gain=gain)[0, 0] * DB_PER_STEP for gain in (30.0, 50.0, 65.0)]
    np.testing.assert_allclose(got, expected, atol=HALF_STEP)


def test_sea_control_falls_with_the_cube_of_range() -> None:
    distance = np.array([5.0, 50.0, 500.0, 5000.0])
    np.testing.assert_allclose(sea_attenuation_db(distance, 100.0), [60.0, 60.0, 30.0, 0.0], atol=1e-12)  # rounding
    np.testing.assert_allclose(sea_attenuation_db(distance, 50.0), [30.0, 30.0, 0.0, 0.0], atol=1e-12)


def test_sea_control_lowers_near_echoes_only() -> None:
    spoke = cells(*[40.0] * 100)  # cells of 10 m
    drop = (shown(spoke)[0].astype(int) - shown(spoke, sea=50.0)[0]) * DB_PER_STEP
    np.testing.assert_allclose(drop[0], 30.0, atol=2 * HALF_STEP)
    assert np.all(drop[50:] == 0)  # 30 dB at 50 m are spent at 500 m


def test_rain_control_takes_the_mean_of_the_cells_before() -> None:
    video = np.array([[10.0, 20.0, -5.0, 30.0, 40.0, 50.0, 60.0]], dtype=np.float32)
    # 50 m are 5 cells of 10 m; what is below the threshold counts as nothing
    expected = [0.0, 10.0, 15.0, 10.0, 15.0, 20.0, 28.0]
    np.testing.assert_allclose(rain_level_db(video, 10.0, 100.0)[0], expected, rtol=1e-6)
    np.testing.assert_allclose(rain_level_db(video, 10.0, 50.0)[0], np.array(expected) / 2, rtol=1e-6)


def test_rain_control_leaves_the_edge_and_removes_the_body_of_a_shower() -> None:
    shower = shown(cells(*[0.0] * 20, *[30.0] * 30, *[0.0] * 10), rain=100.0)[0] * DB_PER_STEP
    assert shower[20] == pytest.approx(30.0, abs=HALF_STEP)
    assert np.all(shower[25:50] == 0)


def sea_spokes(count: int) -> np.ndarray:
    """Spokes of 600 cells of 10 m: noise, and exponential clutter that falls as R^-3 from 40 dB over the noise at 500 m."""
    mean = 1.0 + 1e4 * (500.0 / (100.0 + 10.0 * np.arange(600))) ** 3
    return (NOISE * mean * np.random.default_rng(8).exponential(1.0, (count, 600))).astype(np.float32)


def test_auto_gain_alone_has_one_threshold_over_the_noise() -> None:
    to, automatic = layout(3, 5.0, 10.0), Controls(gain=0.0, sea_auto=False)
    level_db = 10.0 * math.log10(NOISE) + MARGIN_DB + np.array([-1e-4, 1e-4, 10.0 + 1e-4])
    power = (10.0 ** (level_db / 10.0)).astype(np.float32)[None]
    np.testing.assert_array_equal(
        display_video(power, to, automatic, NOISE), [[0, 1, 41]]
    )  # the gain by hand counts for nothing


def test_auto_sea_alone_subtracts_the_local_level_and_leaves_the_gain_by_hand() -> None:
    spokes, to = sea_spokes(4), layout(600, 5.0, 10.0)
    level = clutter_level(spokes, NOISE, 5.0, 10.0)
    expected = np.ceil((decibels(spokes) - level - noise_threshold_db(NOISE) + 10.0) / DB_PER_STEP)  # gain 60
    got = display_video(spokes, to, Controls(gain=60.0, gain_auto=False, sea=100.0), NOISE)
    assert np.abs(got - np.clip(expected, 0, 255)).max() <= 1  # a byte is the nearest step
    assert np.mean(got == np.clip(expected, 0, 255)) > 0.999


def test_a_strong_target_has_the_upper_half_of_the_palette() -> None:
    """45 dB over the sea around it is 33 dB over the threshold: yellow, on a clean display."""
    spokes = sea_spokes(200)
    spokes[100, 200:203] = spokes[:, 200].mean() * 10**4.5
    video = display_video(spokes, layout(600, 5.0, 10.0), Controls(), NOISE)
    assert video[100, 201] > 127 and np.mean(video > 0) < 1e-4


def test_the_bytes_of_a_spoke_depend_on_its_own_cells_alone() -> None:
    """Not on the spokes beside it, and nearer ones not on the display range."""
    spokes, whole = sea_spokes(17), layout(600, 5.0, 10.0)
    bright = Controls(gain=90.0, gain_auto=False)
    together = display_video(spokes, whole, bright, NOISE)
    assert np.mean(together > 0) > 0.9
    for size in (1, 5, 16):
        parts = [display_video(spokes[k : k + size], whole, bright, NOISE) for k in range(0, 17, size)]
        np.testing.assert_array_equal(np.concatenate(parts), together)
    near = layout(600, 5.0, 10.0, None, 1500.0)
    np.testing.assert_array_equal(display_video(spokes, near, bright, NOISE), together[:, : near.samples])


def test_stretch_lengthens_echoes_outward_by_a_share_of_the_range() -> None:
    power, to = cells(*[-30.0] * 500), layout(500, 5.0, 10.0)
    power[0, [100, 498]] = cells(20.0)[0, 0]
    for stretch, length in ((0.0, 1), (1.0, 6), (2.0, 11)):  # 1 % of 500 cells per unit
        video = display_video(power, to, Controls(gain=50.0, gain_auto=False, sea_auto=False, echo_stretch=stretch), NOISE)[
            0
        ]
        expected = [*range(100, 100 + length), *range(498, min(500, 498 + length))]
        assert np.flatnonzero(video).tolist() == expected and len(set(video[expected])) == 1


def rejected(power: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
    controls = Controls(gain=50.0, gain_auto=False, sea_auto=False, interference_rejection=True)
    return display_video(power, layout(power.shape[1], 5.0, 10.0), controls, NOISE, before)


def test_interference_rejection_removes_what_one_spoke_alone_has() -> None:
    """A pulse 60 dB over the noise leaves 6 dB over the cell before it. An echo, which the beam comes over by less than 6 dB
    a spoke, keeps every byte."""
    power = np.full((8, 40), NOISE / 2, dtype=np.float32)
    power[3, 7] = 1e6 * NOISE
    echo = NOISE / 2 * 10.0 ** (np.array([0.0, 5.0, 10.0, 15.0, 20.0, 15.0, 10.0, 5.0]) / 10.0)
    power[:, 20] = echo
    plain = shown(power)
    got = rejected(power)
    assert plain[3, 7] > 0 and not got[:, 7].any()
    np.testing.assert_array_equal(got[:, 20], plain[:, 20])


def test_interference_rejection_removes_another_radar_and_keeps_an_echo() -> None:
    """Where noise of mean 1 came before a pulse, it passes 13.8 x the mean with probability exp(-13.8 / 4): 3 %, and where the
    other radar's pulses meet the same range twice; nine tenths must go."""
    other = {"bearing_deg": 100, "prf_hz": 20_000}
    radar = {"range_max_m": 3000, "modulation": "none", "pulse_s": 0.25e-6, "sample_rate_hz": 8e6}
    bodies = [point("p", 0.0, 1500.0, rcs_dbsm=10.0)]
    simulator = rs.Simulator(scene(bodies, radar=radar, environment={"noise": True}, interference=[other]))
    scan = simulator.scan()
    to, chosen = layout(len(scan.range), float(scan.range[0]), scan.range_step), Controls()
    plain, clean = (
        display_video(scan.power, to, replace(chosen, interference_rejection=on), simulator.noise_power)
        for on in (False, True)
    )
    others = np.abs((scan.azimuth + 1.0) % (2.0 * np.pi) - 1.0) > 0.5  # rows without the echo at north
    assert np.count_nonzero(plain[others]) > 100 and np.count_nonzero(clean[others]) < 0.1 * np.count_nonzero(plain[others])
    assert clean[~others].max() == plain[~others].max() > 100


def test_interference_rejection_does_not_depend_on_where_batches_end() -> None:
    spokes = sea_spokes(17)
    whole = rejected(spokes)
    for size in (1, 5):
        parts = [rejected(spokes[k : k + size], spokes[k - 1] if k else None) for k in range(0, 17, size)]
        np.testing.assert_array_equal(np.concatenate(parts), whole)
    assert np.any(whole != shown(spokes))


@pytest.mark.parametrize("bad", [{"gain": -1.0}, {"sea": 101.0}, {"rain": math.nan}, {"echo_stretch": 2.5}])
def test_controls_outside_their_range_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(bad))):
        Controls(**bad)
