"""Windows of azimuths over tiles and scans."""

import numpy as np
import pytest

from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from radar_service.sources.numbers import source_numbers
from radar_service.sources.power_window import PowerWindow, pulse_powers, scan_powers
from tests.alone import crowded


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
    assert window.transmitting.shape == (stop - first,) and window.clutter.shape == (stop - first, made.radar.bins)
