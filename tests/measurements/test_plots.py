"""The CPU time of the plot extractor in clutter, which grows in proportion to the detections."""

import time
import warnings

import numpy as np
import pytest

from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.flood import FloodWarning
from radar_service.scans.scan import Scan
from tests.plots.test_detections import scan_of_power
from tests.scenes import radar

SCANS = 3


class Above:
    """A threshold by hand."""

    def of(self, power: np.ndarray) -> np.ndarray:
        return np.full((1, 1), 1.0)


def clutter(bins: int, number: int) -> Scan:
    """A scan of 1,024 spokes with spikes of a tenth of its cells, in patches of some cells, up to 50 dB over the threshold."""
    rng = np.random.default_rng(number)
    power = np.full((1024, bins), 0.1)
    spikes = bins * 1024 // 40
    row, cell = rng.integers(0, 1024, spikes), rng.integers(0, bins - 3, spikes)
    for step in range(3):
        power[row, cell + step] = 10.0 ** rng.gamma(1.5, 0.8, spikes)
    return scan_of_power(power, number)


@pytest.mark.bench
def test_extraction_is_in_proportion_to_the_detections() -> None:
    times = []
    for bins in (900, 3600):
        extractor = PlotExtractor(radar(azimuths=1024, beamwidth_deg=1.5, range_max_m=600), Above())
        scans = [clutter(bins, number) for number in range(SCANS)]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FloodWarning)
            extractor.add(scans[0])
            began = time.process_time()
            reports = [extractor.add(scan) for scan in scans[1:]]
            times.append((time.process_time() - began) / (SCANS - 1))
        flood = reports[-1].flood
        assert flood is not None
        print(f"\n{flood.detections:,} detections, {flood.plots + flood.dropped:,} plots: {times[-1]:.3f} s of CPU per scan")
    assert times[1] < 8.0 * times[0]
