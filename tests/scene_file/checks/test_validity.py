"""Scenes outside the valid region of a method give warnings or errors; others do not."""

from typing import Any

import pytest

import radar_service as rs
from tests.scenes import point, scene

BUOY = {"shape": "sphere", "radius_m": 1, "rcs_dbsm": 0}


def warned(text: str, bodies: list[dict[str, Any]] | None = None, **radar: Any) -> bool:
    """Whether loading warns with that text."""
    return any(text in warning for warning in scene(bodies or [], radar=radar).warnings)


def test_a_chirp_whose_samples_fold_gives_a_warning() -> None:
    """About where the stability study finds -40 dB: bandwidth x pulse 13.5 and 1.09 x bandwidth without a window."""
    assert warned("exceeds the sampled band", window="none", pulse_s=10 / 50e6)
    assert not warned("exceeds the sampled band", window="none", pulse_s=14.1 / 50e6)
    assert warned("exceeds the sampled band", window="none", pulse_s=2e-6, sample_rate_hz=54e6)
    assert not warned("exceeds the sampled band", window="none", pulse_s=2e-6, sample_rate_hz=56e6)
    assert not warned("exceeds the sampled band", sample_rate_hz=50e6)
    assert not warned("exceeds the sampled band", window="hamming", pulse_s=5 / 50e6)
    assert not warned("exceeds the sampled band", modulation="none", pulse_s=1e-7)


def test_a_short_chirp_sampled_at_its_bandwidth_gives_a_warning_with_its_error_and_remedies() -> None:
    """-26.6 dB with a Hamming window, as tests/radar/test_folding.py measures."""
    warning = "the field error is -27 dB, above -40 dB: raise sample_rate_hz to 6.25e+07, or lengthen pulse_s to 4e-07"
    assert warned(warning, pulse_s=4 / 50e6, sample_rate_hz=50e6)


def test_doppler_within_a_long_pulse_gives_a_warning() -> None:
    """lambda / (4 T) = 15.48 kn for 1 ms."""
    ferry = {"course_deg": 0}
    assert not warned("Doppler", [point("p", 0, 500, speed_kn=15.4, **ferry)], pulse_s=1e-3)
    assert warned("Doppler", [point("p", 0, 500, speed_kn=15.6, **ferry)], pulse_s=1e-3)
    assert not warned("Doppler", [point("p", 0, 500, speed_kn=40, **ferry)])


def test_bodies_at_rest_far_apart_give_a_warning() -> None:
    near, far = {**BUOY, "name": "near"}, {**BUOY, "name": "far"}
    assert not warned("km apart", [near, {**far, "position_m": [149e3, 0, 0]}])
    assert warned("km apart", [near, {**far, "position_m": [151e3, 0, 0]}])
    assert not warned("km apart", [near, point("far", 151e3, 0)])


def test_echoes_beyond_single_precision_are_refused() -> None:
    loud = {"power_w": 1e9, "gain_dbi": 80, "range_min_m": 1e-2}
    with pytest.raises(rs.SceneError, match=r"range_min_m.*at most 1e\+34 W.*raise range_min_m"):
        scene([point("p", 0, 500, rcs_dbsm=100)], radar=loud)
    scene([point("p", 0, 500, rcs_dbsm=100)], radar={**loud, "range_min_m": 1})
    scene([point("p", 0, 500, rcs_dbsm=10)], radar={"range_min_m": 1e-3})


def test_a_heave_that_dips_the_antenna_is_refused() -> None:
    scene(own_ship={"heave_m": 14.9}, radar={"height_m": 15})
    with pytest.raises(rs.SceneError, match="own_ship.heave_m: 15 m dips the antenna .* less than 15.0 m"):
        scene(own_ship={"heave_m": 15}, radar={"height_m": 15})
    with pytest.raises(rs.SceneError, match="leave it 10.6 m up"):
        scene(own_ship={"heave_m": 11, "roll_deg": 45}, radar={"height_m": 15})
