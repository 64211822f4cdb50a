"""Pulses of a scene file: their defaults, and what a list of them may not be."""

from typing import Any

import pytest

from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.pulse import WAVEFORM_KEYS, PulseModel
from radar_service.world.error import SceneError
from tests.scenes import radar

SHORT = {"modulation": "none", "pulse_s": 8e-8, "range_max_m": 1500}


def test_defaults_are_those_of_a_radar_with_one_pulse() -> None:
    assert WAVEFORM_KEYS == ("modulation", "bandwidth_hz", "pulse_s", "window", "compression")
    assert PulseModel().band_hz == 50e6
    assert PulseModel(modulation="none", pulse_s=0.3e-6).band_hz == pytest.approx(4e6)  # 1.2 / T
    assert PulseModel(bandwidth_hz=20e6).band_hz == 20e6


def test_each_pulse_becomes_a_radar_and_all_have_the_sampling_of_the_widest_band() -> None:
    made = radar(pulses=[SHORT, {"pulse_s": 4e-6, "bandwidth_hz": 20e6}])
    short, long = made.of_each_pulse
    assert (short.modulation, short.pulse, short.bandwidth, short.range_max) == ("none", 8e-8, pytest.approx(15e6), 1500.0)
    assert (long.modulation, long.pulse, long.bandwidth, long.range_max) == ("lfm", 4e-6, 20e6, 5000.0)
    assert short.window == "none" and long.window == "hamming"
    assert short.sample_rate == long.sample_rate == made.sample_rate == 30e6
    assert (short.bins, long.bins) == (301, 1001)  # cells of 4.997 m
    assert short == radar(**SHORT, sample_rate_hz=30e6)
    assert long == radar(pulse_s=4e-6, bandwidth_hz=20e6)
    assert radar(pulses=[{"pulse_s": 4e-6}]) == radar(pulse_s=4e-6)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"pulses": [SHORT, {}], "pulse_s": 1e-6},
            "radar.pulse_s: with pulses, each pulse has its own: move it into pulses",
        ),
        (
            {"pulses": [SHORT, {"range_max_m": 5000}]},
            "radar.pulses[1].range_max_m: the last pulse serves all farther ranges",
        ),
        ({"pulses": [{"pulse_s": 1e-7, "modulation": "none"}, {}]}, "radar.pulses[0].range_max_m: it is missing"),
        ({"pulses": [SHORT, SHORT, {}]}, "radar.pulses[1].range_max_m: 1500 m; the ends rise strictly, from above 1500 m"),
        ({"pulses": [SHORT, {}], "range_max_m": 1200}, "to below range_max_m, 1200 m: correct it"),
        (
            {"pulses": [SHORT, {"pulse_s": 1e-8}]},
            "radar.pulses[1].pulse_s: bandwidth x pulse is 0.5; a chirp needs at least 4",
        ),
        ({"pulses": [{**SHORT, "window": "hann"}, {}]}, 'radar.pulses[0].window: "hann" needs a chirp'),
        ({"pulses": [SHORT, {"compression": "inverse"}]}, 'radar.pulses[1].compression: "inverse" with window "hamming"'),
        ({"pulses": [SHORT, {}], "sample_rate_hz": 20e6}, "radar.sample_rate_hz: 2e+07 is below the bandwidth"),
        ({"pulses": [SHORT, {"pulse": 1}]}, "radar.pulses[1].pulse"),
        ({"pulses": [SHORT, {"pulse_s": 0}]}, "radar.pulses[1].pulse_s: 0"),
        ({"pulses": [SHORT] * 9}, "radar.pulses"),
        ({"pulses": [SHORT, {}], "beamwidth_deg": 0.4}, "radar.beamwidth_deg: 0.4 degrees are narrower"),
        ({"pulses": [SHORT, {}], "prf_hz": 35_000}, "5000 m is beyond the 4283 m"),
    ],
)
def test_impossible_lists_are_refused_with_the_remedy(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as fault:
        load_scene({"radar": settings})
    assert message in str(fault.value)
