"""Scan-to-scan correlation: false alarms by theory, steady and moving echoes, own ship under way."""

import math

import numpy as np
import pytest

from radar_service.display.scan_correlation import SPEED, ScanMemory, excess_db
from radar_service.display.video import Controls, display_video, layout, noise_threshold_db
from radar_service.records.spokes import SpokeBlock
from radar_service.scene_file.load import load_scene

NOISE = 1e-15  # W
RADAR = load_scene({"radar": {"azimuths": 64, "beamwidth_deg": 15, "rpm": 24}}).radar
AZIMUTHS, PERIOD = RADAR.azimuths, RADAR.rotation_period
BLOCK = 4  # cells
STEP = SPEED * PERIOD / (BLOCK - 0.1)  # m
AT_REST = np.zeros(2)
BY_HAND = Controls(gain=50.0, gain_auto=False, sea_auto=False)
ON = Controls(gain=50.0, gain_auto=False, sea_auto=False, scan_correlation=True)


def spokes(first: int, power: np.ndarray, position: np.ndarray = AT_REST) -> SpokeBlock:
    """Consecutive spokes of these cells (K, N) [W], seen from a position [m]."""
    count, cells = power.shape
    number, zeros = first + np.arange(count), np.zeros(count)
    return SpokeBlock(
        first, first // AZIMUTHS, first % AZIMUTHS, number * PERIOD / AZIMUTHS, number % AZIMUTHS * RADAR.azimuth_step, zeros,
        np.broadcast_to(position, (count, 2)), zeros, zeros, (np.arange(cells) + 0.5) * STEP, STEP,
        np.sqrt(power).astype(np.complex64), power.astype(np.float32),
    )  # fmt: skip


def memory(cells: int) -> ScanMemory:
    return ScanMemory(RADAR, (np.arange(cells) + 0.5) * STEP, STEP)


def noise(seed: int, cells: int) -> np.ndarray:
    return (NOISE * np.random.default_rng(seed).exponential(1.0, (AZIMUTHS, cells))).astype(np.float32)


def video(power: np.ndarray, controls: Controls, earlier: np.ndarray | None = None) -> np.ndarray:
    return display_video(power, layout(power.shape[1], STEP / 2, STEP), controls, NOISE, None, earlier)


def test_spikes_that_come_and_go_are_shown_as_often_as_two_scans_have_them() -> None:
    """A cell of exponential power exceeds the threshold with p; one of the 3 BLOCK cells around its place must have done so a
    scan ago, with 1 - (1 - p)^(3 BLOCK). Five standard deviations; cells of a block share their past, which adds 3 % to one."""
    cells = 4000
    bright = Controls(gain=54.0, gain_auto=False, sea_auto=False, scan_correlation=True)
    p = math.exp(-(10.0 ** ((noise_threshold_db(NOISE) - 4.0) / 10.0)) / NOISE)
    expected = p * (1.0 - (1.0 - p) ** (3 * BLOCK))
    of = memory(cells)
    of.take(spokes(0, noise(1, cells)))
    now = spokes(AZIMUTHS, noise(2, cells))
    shown = np.mean(video(now.power, bright, of.take(now)) > 0)
    assert abs(shown - expected) < 5.2 * math.sqrt(expected / now.power.size)
    assert np.mean(video(now.power, bright) > 0) > 3 * expected


def test_a_steady_echo_in_noise_keeps_its_strength() -> None:
    """20 dB over the noise, with noise on top: the strongest of 12 cells around the lesser of two scans is at most the lesser
    one, some 0.9 dB weaker than the mean; 2 dB. It is shown every time."""
    of, seen = memory(100), []
    for scan in range(6):
        field = np.sqrt(noise(scan, 100)) * np.exp(2j * np.pi * np.random.default_rng(scan + 9).random((AZIMUTHS, 100)))
        field[:, 50] += math.sqrt(100 * NOISE)
        block = spokes(scan * AZIMUTHS, np.abs(field) ** 2)
        earlier = of.take(block)
        seen.append([video(block.power, controls, earlier)[:, 50] for controls in (BY_HAND, ON)])
    plain, correlated = np.array(seen[1:]).swapaxes(0, 1)
    assert correlated.min() > 0 and 0 < plain.mean() - correlated.mean() < 8  # steps of 0.25 dB


def test_no_cell_gets_stronger_and_the_level_of_clutter_stays() -> None:
    """Also with automatics and rain control, which subtract levels of the cells as they are."""
    of = memory(400)
    of.take(spokes(0, noise(1, 400) * 1e3))
    now = spokes(AZIMUTHS, noise(2, 400) * 1e3)
    earlier, auto = of.take(now), {"rain": 50.0, "interference_rejection": True}
    plain, correlated = (video(now.power, Controls(**auto, scan_correlation=on), earlier) for on in (False, True))  # type: ignore[arg-type]
    assert np.all((correlated == plain) | (correlated < plain)) and np.any(correlated < plain)
    allowed = now.power <= earlier
    np.testing.assert_array_equal(correlated[allowed], plain[allowed])


def test_off_it_changes_no_byte_and_unknown_pasts_change_none() -> None:
    power = noise(3, 60) * 100
    plain = video(power, BY_HAND)
    np.testing.assert_array_equal(video(power, BY_HAND, power / 1000), plain)
    np.testing.assert_array_equal(video(power, ON), plain)
    np.testing.assert_array_equal(video(power, ON, memory(60).take(spokes(0, power))), plain)
    assert np.any(video(power, ON, power / 1000) != plain)


def one_cell(row: int, cell: int) -> np.ndarray:
    power = np.zeros((AZIMUTHS, 200), dtype=np.float32)
    power[row, cell] = 1.0
    return power


@pytest.mark.parametrize("begin", range(80, 80 + BLOCK))
@pytest.mark.parametrize("direction", [-1, 1])
def test_craft_are_kept_up_to_the_speed_and_lost_at_twice_it(begin: int, direction: int) -> None:
    for cells, kept in ((BLOCK, True), (2 * BLOCK, False)):  # a block is SPEED x the period of rotation
        of = memory(200)
        of.take(spokes(0, one_cell(7, begin)))
        now = one_cell(7, begin + direction * cells)
        shown = video(now, ON, of.take(spokes(AZIMUTHS, now)))
        assert bool(shown.max() > 0) is kept


def seen_from(position: np.ndarray, buoy: np.ndarray) -> np.ndarray:
    """A scan in which three spokes, a beamwidth, have a buoy."""
    east, north = buoy - position
    row = round(math.atan2(east, north) / RADAR.azimuth_step)
    return sum((one_cell((row + k) % AZIMUTHS, int(math.hypot(east, north) / STEP)) for k in (-1, 0, 1)), np.zeros(1))


@pytest.mark.parametrize("course", np.arange(0.0, 6.0, 0.9))
def test_under_way_a_buoy_is_found_where_it_is_over_ground(course: float) -> None:
    """Own ship at 60 m/s passes a buoy close by. Where it is not reported to move, the buoy has no past."""
    buoy, moved = np.array([300.0, 100.0]), 60.0 * PERIOD * np.array([math.sin(course), math.cos(course)])
    before, now = seen_from(AT_REST, buoy), seen_from(moved, buoy)
    of, deaf = memory(200), memory(200)
    of.take(spokes(0, before))
    deaf.take(spokes(0, before))
    assert video(now, ON, of.take(spokes(AZIMUTHS, now, moved))).max() > 0
    assert video(now, ON, deaf.take(spokes(AZIMUTHS, now))).max() == 0
    assert np.isposinf(of.take(spokes(2 * AZIMUTHS, now, moved + [1e6, 0.0]))).all()  # another place on earth


def test_a_position_that_is_not_reported_counts_as_kept() -> None:
    of, now = memory(200), one_cell(7, 50)
    of.take(spokes(0, now))
    assert of.take(spokes(AZIMUTHS, now, np.full(2, math.nan)))[7, 50] == 1.0


def test_missing_spokes_have_no_past() -> None:
    of, power = memory(40), noise(4, 40)
    of.take(spokes(0, power[:10]))
    of.take(spokes(20, power[20:]))
    earlier = of.take(spokes(AZIMUTHS, power))
    assert np.flatnonzero(np.isposinf(earlier).all(axis=1)).tolist() == list(range(10, 20))
    assert np.isfinite(earlier[:10]).all()
    of.take(spokes(5 * AZIMUTHS, power))  # after a long gap the old scan is none
    assert np.isposinf(of.take(spokes(8 * AZIMUTHS, power))).all()


@pytest.mark.parametrize("size", [1, 7, AZIMUTHS])
def test_where_batches_end_makes_no_difference(size: int) -> None:
    def pasts(size: int) -> np.ndarray:
        of, found = memory(50), []
        for scan in range(3):
            power, position = noise(scan, 50), np.array([100.0, 60.0]) * scan
            for k in range(0, AZIMUTHS, size):
                found.append(of.take(spokes(scan * AZIMUTHS + k, power[k : k + size], position)))
        return np.concatenate(found)

    np.testing.assert_array_equal(pasts(size), pasts(16))


def test_excess_counts_nothing_over_nothing_as_none() -> None:
    power = np.array([[0.0, 1.0, 10.0, 5.0, 5.0]], dtype=np.float32)
    earlier = np.array([[0.0, 2.0, 1.0, 0.0, np.inf]], dtype=np.float32)
    np.testing.assert_allclose(excess_db(power, earlier), [[0.0, 0.0, 10.0, np.inf, 0.0]], rtol=1e-6)  # float32
