"""Windows of azimuths over tiles and scans."""

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from radar_service.sources.numbers import NOISE, source_numbers
from radar_service.sources.power_window import PowerWindow, SourcePowers, pulse_powers, scan_powers
from radar_service.stages.clutter.effect import RAIN, SEA
from tests.alone import crowded, crowded_alone
from tests.scenes import point, scene


@pytest.mark.sample(2)
@pytest.mark.parametrize(("first", "stop"), [(0, 5), (65, 80), (70, 150), (144, 145)])
def test_a_window_has_the_azimuths_of_its_scans(first: int, stop: int) -> None:
    made = crowded(True)
    pulses = pulse_powers([prepare(made, PRESETS["balanced"], 0)], source_numbers(made))
    window = PowerWindow(pulses, first, stop)
    assert window.number.tolist() == list(range(first, stop))
    scans = {scan: scan_powers(pulses, scan) for scan in range(first // 72, (stop - 1) // 72 + 1)}
    absent = np.zeros((72, made.radar.bins), dtype=np.float32)
    for number in {number for scan in scans.values() for number in scan}:
        expected = np.stack([scans[n // 72].get(number, absent)[n % 72] for n in range(first, stop)])
        np.testing.assert_array_equal(window.power(number), expected)
        assert number in window.sources or not expected.any()
    assert not window.power(999).any() and window.power(999).shape == (stop - first, made.radar.bins)
    assert window.transmitting.shape == (stop - first,) and window.background.shape == (stop - first, made.radar.bins)


@pytest.mark.parametrize("moves", [False, True], ids=["at rest", "own ship under way"])
def test_powers_are_those_of_separately_run_sources(moves: bool) -> None:
    """To -66 dB of the strongest echo and -60 dB of each: together, echoes are shifted by series, and those of a shadow that
    cancel others stand on another kernel. Sea and rain share a power, to single precision."""
    made = crowded(moves)
    powers = scan_powers(pulse_powers([prepare(made, PRESETS["balanced"], 0)], source_numbers(made)), 2)
    alone = crowded_alone(moves).powers(2)
    assert {number for number, power in alone.items() if power.any()} == set(powers)
    for number, power in powers.items():
        got, expected = np.sqrt(power, dtype=np.float64), np.sqrt(alone[number])
        part = 5e-4 if number > 3 else 1.7e-3  # the square is 3e-6
        np.testing.assert_allclose(got, expected, rtol=1e-3, atol=part * expected.max(), err_msg=str(number))


def test_clutter_is_its_mean_over_speckle_and_tiles_are_kept() -> None:
    """Over 60 scans at rest the sea's and the rain's power average to it within a tenth, 1.3 / root 60 twice over."""
    made = crowded(False, sea_state=3, rain_mm_h=2.0).with_world(bodies=())
    powers = SourcePowers(prepare(made, PRESETS["balanced"], 0), source_numbers(made))
    ratios = []
    for scan in range(60):
        tile = powers.tile(scan, 0)
        assert powers.tile(scan, 0) is tile
        mean, drawn = tile.background[:, 40:60], (tile.power[SEA] + tile.power[RAIN])[:, 40:60]
        ratios.append(float((drawn / mean).mean()))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.1)


def test_nothing_but_noise_and_interference_is_received_where_the_radar_is_blind() -> None:
    made = crowded(False)
    powers = SourcePowers(prepare(made, PRESETS["balanced"], 0), source_numbers(made))
    tile = powers.prepared.tile
    part = powers.tile(0, 35 // tile * tile)  # azimuth 35 of 72 looks along 175 degrees
    row = 35 % tile
    assert not part.transmitting[row] and part.transmitting[0]
    assert not part.background[row].any()
    assert [number for number, power in part.power.items() if power[row].any() and number != 3] == [NOISE]


def test_the_answer_of_a_beacon_is_the_field_without_it() -> None:
    """Without noise and with a buoy that hardly reflects, the power of source 5 is that of the scan, at any number of threads and
    from any start."""
    radar = {"range_max_m": 3000, "azimuths": 90, "beamwidth_deg": 8, "modulation": "none", "pulse_s": 2e-7, "bandwidth_hz": 5e6,
             "sample_rate_hz": 15e6}  # fmt: skip
    made = scene([point("b", 0, 1500, rcs_dbsm=-90.0, racon={"letter": "K", "mark_m": 900})], radar=radar)
    scan = rs.Simulator(made, "fast", seed=3).scan()
    powers = rs.Simulator(made, "fast", seed=3).source_powers(0)[5]
    strong = scan.power > 1e-6 * scan.power.max()
    np.testing.assert_allclose(powers[strong], scan.power[strong], rtol=1e-2)
    again = rs.Simulator(made, "fast", seed=3, threads=2)
    np.testing.assert_array_equal(again.scan().field, scan.field)
    labels = rs.Simulator(made, "fast", seed=3, labels=True).scan().labels
    assert labels is not None and (labels[strong] == 5).all()
