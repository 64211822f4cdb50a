"""Radar settings that the physics cannot compute together are refused with the reason."""

from typing import Any

import pytest

from radar_service.radar.patterns import PATTERNS
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.radar import WAVEFORM_KEYS, PulseModel
from radar_service.world.error import SceneError
from tests.scenes import radar

LIGHT = 299_792_458.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sample_rate_hz": 40e6}, "radar.sample_rate_hz: 4e+07 is below the bandwidth; complex sampling needs at least"),
        ({"beamwidth_deg": 0.4}, "radar.beamwidth_deg: 0.4 degrees are narrower than the 0.5 degrees from spoke to spoke"),
        ({"beamwidth_deg": 0.4}, "raise azimuths to 900 or set coarse_azimuths = true"),
        ({"pulse_s": 0.05e-6}, 'radar.pulse_s: bandwidth x pulse is 2.5; a chirp needs at least 4: lengthen the pulse'),
        ({"pulse_s": 1e-3, "prf_hz": 1000, "bandwidth_hz": 1e6}, "radar.pulse_s: 0.001 s is not below the 0.001 s"),
        ({"prf_hz": 250}, "radar.prf_hz: 250 is less than a pulse for each of the 288 spokes a second"),
        ({"prf_hz": 40_000}, "radar.range_max_m: 5000 m is beyond the 3747 m from which echoes of 40000 pulses a second"),
        ({"second_time_around": True}, "radar.second_time_around: it needs a pulse repetition frequency; add prf_hz"),
        ({"modulation": "none"}, None),
        ({"modulation": "none", "bandwidth_hz": 50e6}, "radar.bandwidth_hz: 5e+07 Hz x 1e-05 s is 500; the receiver"),
        ({"modulation": "none", "window": "hamming"}, 'radar.window: "hamming" needs a chirp, and modulation = "none"'),
        ({"modulation": "none", "compression": "inverse"}, 'radar.compression: "inverse" needs a chirp, and modulation = "none"'),
        ({"modulation": "nlfm", "window": "hamming"}, None),
        ({"compression": "inverse", "window": "nuttall"}, None),
        ({"compression": "inverse"}, 'radar.compression: "inverse" with window "hamming" leaves sidelobes along the'),
        ({"modulation": "nlfm", "pulse_s": 0.05e-6}, "radar.pulse_s: bandwidth x pulse is 2.5; a chirp needs at least 4"),
        ({"modulation": "nlfm", "pulse_s": 5e-4}, "radar.pulse_s: bandwidth x pulse is 2.5e+04; a nonlinear chirp has at most"),
        ({"pattern_el": [[0, 0], [0, -3]]}, "radar.pattern_el: the offsets start at 0 and rise strictly"),
        ({"beamwidth_deg": 0.1, "coarse_azimuths": True, "range_max_m": 20_000},
         "radar.beamwidth_deg: 0.1 degrees need a grid of 18720 rows x 10007 range bins; at most 134217728 cells"),
        ({"pattern": [[0, 0], [0.1, -3.0103], [1, -40]]}, "radar.pattern: 0.2016 degrees are narrower than the 0.5 degrees"),
        ({"pattern": [[0, 0], [1e-3, -40]], "coarse_azimuths": True}, "radar.pattern: 0.0036"),
        ({"taylor_nbar": 1}, "radar.taylor_nbar: 1 is not allowed; a whole number from 2 to 20; raise it"),
    ],
)  # fmt: skip
def test_impossible_settings_are_refused_with_the_remedy(settings: dict[str, Any], message: str | None) -> None:
    if message is None:
        load_scene({"radar": settings})
        return
    with pytest.raises(SceneError) as fault:
        load_scene({"radar": settings})
    assert message in str(fault.value)


@pytest.mark.parametrize(
    "settings",
    [
        {"beamwidth_deg": 0.4, "coarse_azimuths": True},
        {"beamwidth_deg": 0.5},  # exactly a step
        {"prf_hz": 288},  # exactly a pulse to a spoke
        {"prf_hz": 40_000, "second_time_around": True},
        {"prf_hz": LIGHT / 10_000},  # exactly to range_max_m
        {"sample_rate_hz": 50e6},
    ],
)
def test_settings_at_the_limit_are_accepted(settings: dict[str, Any]) -> None:
    load_scene({"radar": settings})


@pytest.mark.parametrize("name", PATTERNS)
def test_the_bound_on_the_grid_is_that_of_the_engine(name: str) -> None:
    """The grid has 2.9 x 2 rows for each wavelength over the aperture, whose half-power width is 0.8859 `aperture_width`
    lambda / a (tests/radar/test_patterns.py). The margin of 1 % covers four digits and whole multiples of 16 azimuths."""
    settings = {"pattern": name, "azimuths": 16, "coarse_azimuths": True, "range_max_m": 20_000}
    finest_deg = 2.9 * 2.0 * 0.8859 * PATTERNS[name].aperture_width * 360.0 * 10_007 / 2**27
    assert load_scene({"radar": settings | {"beamwidth_deg": finest_deg * 1.01}}).radar.bins == 10_007
    with pytest.raises(SceneError, match="at most 134217728 cells"):
        load_scene({"radar": settings | {"beamwidth_deg": finest_deg * 0.99}})


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
        ({"pulses": [SHORT, {}], "pulse_s": 1e-6}, "radar.pulse_s: with pulses, each pulse has its own: move it into pulses"),
        ({"pulses": [SHORT, {"range_max_m": 5000}]}, "radar.pulses[1].range_max_m: the last pulse serves all farther ranges"),
        ({"pulses": [{"pulse_s": 1e-7, "modulation": "none"}, {}]}, "radar.pulses[0].range_max_m: it is missing"),
        ({"pulses": [SHORT, SHORT, {}]}, "radar.pulses[1].range_max_m: 1500 m; the ends rise strictly, from above 1500 m"),
        ({"pulses": [SHORT, {}], "range_max_m": 1200}, "to below range_max_m, 1200 m: correct it"),
        ({"pulses": [SHORT, {"pulse_s": 1e-8}]},
         "radar.pulses[1].pulse_s: bandwidth x pulse is 0.5; a chirp needs at least 4"),
        ({"pulses": [{**SHORT, "window": "hann"}, {}]}, 'radar.pulses[0].window: "hann" needs a chirp'),
        ({"pulses": [SHORT, {"compression": "inverse"}]}, 'radar.pulses[1].compression: "inverse" with window "hamming"'),
        ({"pulses": [SHORT, {}], "sample_rate_hz": 20e6}, "radar.sample_rate_hz: 2e+07 is below the bandwidth"),
        ({"pulses": [SHORT, {"pulse": 1}]}, "radar.pulses[1].pulse"),
        ({"pulses": [SHORT, {"pulse_s": 0}]}, "radar.pulses[1].pulse_s: 0"),
        ({"pulses": [SHORT] * 9}, "radar.pulses"),
        ({"pulses": [SHORT, {}], "beamwidth_deg": 0.4}, "radar.beamwidth_deg: 0.4 degrees are narrower"),
        ({"pulses": [SHORT, {}], "prf_hz": 35_000}, "5000 m is beyond the 4283 m"),
    ],
)  # fmt: skip
def test_impossible_lists_are_refused_with_the_remedy(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as fault:
        load_scene({"radar": settings})
    assert message in str(fault.value)
