"""The sidelobe gate: envelopes against own closed forms, and what it keeps."""

import numpy as np
import pytest

from radar_service.radar.parameters import Radar
from radar_service.tracking.detections import Detections
from radar_service.tracking.sidelobes import SidelobeGate, azimuth_envelope, range_envelope
from tests.reference.compressed_pulse import LIGHT, compressed_pulse, sinc2_beam
from tests.scenes import radar

SETTINGS = {
    "azimuths": 720,
    "beamwidth_deg": 4,
    "range_max_m": 3000,
    "pulse_s": 2e-6,
    "bandwidth_hz": 20e6,
    "window": "hamming",
}


@pytest.fixture(scope="module")
def settings() -> Radar:
    return radar(**SETTINGS)


def test_the_envelope_in_azimuth_is_the_highest_sidelobe_beyond(settings: Radar) -> None:
    """A sinc^2 beam: two-way sidelobes fall with the square of the one-way gain. 2 %: the table's steps of a sixteenth."""
    envelope = azimuth_envelope(settings)
    fine = np.linspace(0, np.pi, 200_001)
    gain = sinc2_beam(fine, np.radians(4)) ** 2
    for spokes in (0, 3, 12, 17, 40, 200):
        exact = gain[fine >= np.radians(spokes * 0.5) - 1e-9].max()
        assert envelope[spokes] == pytest.approx(exact, rel=0.02)
    assert len(envelope) == 361 and (np.diff(envelope) <= 0).all()


def test_the_envelope_in_range_is_the_highest_sidelobe_beyond(settings: Radar) -> None:
    """The compressed chirp by closed form at the samples. 0.1 dB, and -70 dB of the peak: the kernel of the grid."""
    envelope = range_envelope(settings)
    cells = np.arange(len(envelope)) * settings.range_step
    profile = np.abs(compressed_pulse(2 * cells / LIGHT, settings.bandwidth, settings.pulse, (0.54, 0.46))) ** 2
    exact = np.maximum.accumulate(profile[::-1])[::-1]
    assert envelope == pytest.approx(exact, rel=0.023, abs=1e-7)


def detection(spoke: int, cell: int, power: float) -> Detections:
    zero = np.zeros(1)
    return Detections(np.array([spoke]), np.array([cell]), np.array([power]), zero, zero, zero, zero, zero)


@pytest.mark.parametrize(
    ("spoke", "cell", "gated"),
    [
        (100, 60, True),
        (100, 300, False),
        (112, 50, True),
        (101, 61, True),
        (112, 60, False),
        (811, 50, True),
        (460, 50, False),
    ],
)
def test_what_a_stronger_echo_explains_is_gated(settings: Radar, spoke: int, cell: int, gated: bool) -> None:
    """60 dB above: its sidelobes are at most -27 dB two-way in azimuth near it, -43 dB in range, and none beyond the pulse."""
    strong, weak = detection(100, 50, 1e6), detection(spoke, cell, 1.0)
    gate = SidelobeGate(settings, 3.0)
    assert gate.is_sidelobe(weak, strong.and_then(weak)) is gated
    assert not gate.is_sidelobe(strong, strong.and_then(weak)) and not gate.is_sidelobe(weak, weak)
