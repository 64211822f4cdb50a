"""The sidelobe gate: envelopes against own closed forms, and what it keeps."""

import numpy as np
import pytest

from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.plots.detections import Detections
from radar_service.plots.sidelobes import (
    DetectionBoxes,
    DetectionTree,
    SidelobeGate,
    azimuth_envelope,
    distances,
    range_envelope,
)
from radar_service.radar.parameters import Radar
from radar_service.receive.compression import receiver_noise_power
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
        (811, 50, True),
        (460, 50, False),
    ],
)
def test_what_a_stronger_echo_explains_is_gated(settings: Radar, spoke: int, cell: int, gated: bool) -> None:
    """60 dB: sidelobes are at most -27 dB two-way in azimuth, -43 dB in range, both at both, none beyond it."""
    noise = receiver_noise_power(settings)
    strong, weak = detection(100, 50, 1e6 * noise), detection(spoke, cell, 12.0 * noise)
    gate = SidelobeGate(settings, 3.0)
    assert gate.sidelobes(strong.and_then(weak), np.arange(2), np.arange(2)).tolist() == [False, gated]
    assert not gate.sidelobes(weak, np.arange(1), np.arange(1)).any()


def test_the_gate_is_that_of_all_pairs(settings: Radar) -> None:
    """A flood of two scans: plots of 3 cells beside each other, among cells of no plot; levels as of clutter and of ships."""
    rng, noise = np.random.default_rng(5), receiver_noise_power(settings)
    spoke, cell = np.repeat(rng.integers(0, 1440, 400), 3), np.repeat(rng.integers(0, 300, 400), 3) + np.tile([0, 1, 2], 400)
    power, zero = noise * 10.0 ** rng.gamma(2.0, 0.9, 1200) * 16.0, np.zeros(1200)
    every = Detections(spoke, cell, power, zero, zero, zero, zero, zero)
    plot = np.repeat(np.where(np.arange(400) < 300, np.arange(400), -1), 3)
    peak = np.arange(300) * 3 + power.reshape(400, 3)[:300].argmax(axis=1)
    envelopes = azimuth_envelope(settings), range_envelope(settings)
    expected = [explained(settings, envelopes, every, int(one), plot == number) for number, one in enumerate(peak)]
    gate = SidelobeGate(settings, 3.0)
    result = gate.sidelobes(every, peak, plot)
    assert result.tolist() == expected and 15 < result.sum() < 270
    alone = [gate.sidelobes(every, peak[n : n + 1], np.where(plot == n, 0, -1)) for n in range(30)]  # few pairs: no search
    assert np.concatenate(alone).tolist() == expected[:30] and 0 < sum(expected[:30]) < 30


def explained(radar: Radar, envelopes: tuple[Floats, Floats], every: Detections, peak: int, own: Flags) -> bool:
    """One plot against all detections; envelopes: over azimuth and range."""
    margin, (azimuth, along) = 10**0.3, envelopes
    apart = np.abs(every.spoke - every.spoke[peak])
    across = np.minimum(apart % radar.azimuths, -apart % radar.azimuths)
    cells = np.clip(np.abs(every.cell - every.cell[peak]), 1, len(along) - 1) - 1
    level = every.power * azimuth[across] * along[cells]
    again = (apart > radar.azimuths // 2) & (azimuth[across] > 0.01)
    usable = ~own & ~again & (every.power * margin > every.power[peak])
    noise = 2.5 * np.sqrt(receiver_noise_power(radar))
    return bool(np.sqrt(every.power[peak]) <= np.sqrt(level[usable].max(initial=0.0) * margin) + noise)


def test_the_nearest_of_a_box() -> None:
    near, far = distances(np.array([0, 5, 20]), np.array([[3, 3, 3], [9, 9, 9]]))
    assert near.tolist() == [3, 0, 11] and far.tolist() == [9, 4, 17]


REACH = 3


class Near:
    """Queries at detections: whether a stronger one lies within REACH spokes and cells. It counts the pairs it is given."""

    def __init__(self, detections: Detections) -> None:
        self.all, self.pairs = detections, 0

    def may(self, query: Indices, boxes: DetectionBoxes, box: Indices) -> Flags:
        self.pairs += len(query)
        near = self.all.power[boxes.strongest[box]] > self.all.power[query]
        for position, interval in ((self.all.spoke, boxes.spoke), (self.all.cell, boxes.cell)):
            near &= (interval[0, box] <= position[query] + REACH) & (interval[1, box] >= position[query] - REACH)
        return near

    def does(self, query: Indices, echo: Indices) -> Flags:
        self.pairs += len(query)
        near = self.all.power[echo] > self.all.power[query]
        for position in (self.all.spoke, self.all.cell):
            near &= np.abs(position[echo] - position[query]) <= REACH
        return near

    def search(self) -> Flags:
        return DetectionTree(self.all).any(len(self.all), self.may, self.does)


def drawn(count: int) -> Detections:
    """Detections at random in 60 range cells, as dense over as many spokes as they take."""
    rng, zero = np.random.default_rng(count), np.zeros(count)
    spoke, cell = rng.integers(0, count // 6 + 1, count), rng.integers(0, 60, count)
    return Detections(spoke, cell, rng.permutation(count) + 1.0, zero, zero, zero, zero, zero)


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 500])
def test_the_search_finds_what_all_pairs_find(count: int) -> None:
    near = Near(drawn(count))
    query, echo = (axis.ravel() for axis in np.mgrid[:count, :count])
    expected = near.does(query, echo).reshape(count, count).any(axis=1)
    assert (near.search() == expected).all() and (count < 500 or 0 < expected.sum() < count)


def test_the_pairs_grow_as_n_log_n() -> None:
    """Four times as many detections take 4 to 4 log(4 n) / log(n) = 4.7 times as many pairs; all pairs would be 16 times."""
    few, many = Near(drawn(3_000)), Near(drawn(12_000))
    few.search(), many.search()
    assert many.pairs < 5.0 * few.pairs and many.pairs < 0.02 * 12_000**2
