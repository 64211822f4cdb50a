"""The resolution cell and the levels of clutter against integrals and the radar equation by hand."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.receive.compression import compression_for
from radar_service.stages.clutter.resolution_cell import (
    ResolutionCell,
    pulse_power,
    received_share,
    resolution_cell,
    unit_power,
)  # fmt: skip
from tests.reference.compressed_pulse import compressed_pulse
from tests.scenes import radar, scene

LIGHT = 299_792_458.0
HAMMING = (0.54, 0.46)


def gaussian(offset: NDArray[np.float64]) -> NDArray[np.float64]:
    """A Gaussian beam of half-power width 0.05 rad."""
    return np.exp(-4 * np.log(2) * (offset / 0.05) ** 2)


def test_the_width_of_a_gaussian_beam_is_its_two_way_integral() -> None:
    """The integral of exp(-8 ln 2 t^2 / b^2) is b sqrt(pi / (8 ln 2)); the sum over 65 536 offsets is exact to rounding."""
    cell = resolution_cell(gaussian, compression_for(radar(), 6), 2.0)
    assert cell.width == pytest.approx(0.05 * np.sqrt(np.pi / (8 * np.log(2))), rel=1e-9)


def test_the_length_is_the_energy_of_the_compressed_pulse() -> None:
    """Sum of the closed form over samples; 1e-3: the band cuts the spectrum of a chirp of 500 cycles."""
    made = radar(bandwidth_hz=50e6, pulse_s=10e-6)
    compression = compression_for(made, 6)
    pulse = compressed_pulse(np.arange(-800, 801) / made.sample_rate, 50e6, 10e-6, HAMMING)
    energy = float(np.sum(np.abs(pulse) ** 2))
    assert float(np.mean(pulse_power(compression))) == pytest.approx(energy, rel=1e-3)
    assert resolution_cell(gaussian, compression, 2.0).length == pytest.approx(2.0 * energy, rel=1e-3)


def test_the_area_grows_with_range() -> None:
    np.testing.assert_allclose(ResolutionCell(0.02, 3.0).area(np.array([0.0, 1000.0, 4000.0])), [0.0, 60.0, 240.0])


def test_the_unit_power_is_the_radar_equation_with_gas_and_rain() -> None:
    """25 kW, 30 dBi, 31.859 mm at 5 km, 0.1 dB/km of gas and 0.332 dB/km of 16 mm/h rain (P.838, three digits), 10 km of path."""
    made = scene(radar={"range_max_m": 6000}, environment={"gas_db_per_km": 0.1, "rain_mm_h": 16})
    wavelength = LIGHT / 9.41e9
    free = 25e3 * 1e6 * wavelength**2 / ((4 * np.pi) ** 3 * 5000.0**4)
    loss_db = 10.0 * (0.1 + 0.332)
    assert unit_power(made, np.array([5000.0]))[0] == pytest.approx(free * 10 ** (-loss_db / 10), rel=2e-3)  # half a digit


def test_a_radar_with_two_antennas_receives_all() -> None:
    made = scene(radar={"range_max_m": 1200})
    np.testing.assert_array_equal(received_share(made, compression_for(made.radar, 6)), np.ones(made.radar.bins))


def test_the_received_share_is_the_energy_of_the_truncated_echo() -> None:
    """The closed form of an echo whose first T - 2R/c is eclipsed; 1.5 %: 64 ranges are interpolated, and sidelobes before
    range 0 are missing. Beyond c T / 2 the share is 1."""
    made = scene(radar={"pulse_s": 4e-6, "range_max_m": 1200, "eclipsing": True})
    share = received_share(made, compression_for(made.radar, 6))
    delays = np.arange(-2000, 2001) / made.radar.sample_rate
    whole = np.sum(np.abs(compressed_pulse(delays, made.radar.bandwidth, 4e-6, HAMMING)) ** 2)
    for column in (30, 75, 150, 200, 260):
        late = (column + 0.5) / made.radar.sample_rate
        received = compressed_pulse(delays, made.radar.bandwidth, 4e-6, HAMMING, 2e-6 - late)
        assert share[column] == pytest.approx(np.sum(np.abs(received) ** 2) / whole, abs=0.015)
    assert (share[303:] == 1.0).all() and share[0] < 1e-3
