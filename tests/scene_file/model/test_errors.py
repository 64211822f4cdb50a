"""The tables of errors in a scene file: what they allow, and what they say about the rest."""

from typing import Any

import pytest

import radar_service as rs


@pytest.mark.parametrize(
    ("errors", "message"),
    [
        ({"gyro": {"bias_deg": float("nan")}}, "errors.gyro.bias_deg: nan is not allowed; a finite number from -180 to 180"),
        ({"gyro": {"bais_deg": 1}}, 'errors.gyro.bais_deg: this is not a known key; did you mean "bias_deg"?'),
        ({"gyro": {"noise_deg": -1}}, "errors.gyro.noise_deg: -1 is not allowed; a finite number from 0 to 45; raise it"),
        ({"log": {"bias_kn": "1"}}, 'errors.log.bias_kn: "1" is not allowed'),
        ({"log": {"latency_s": 11}}, "errors.log.latency_s: 11 is not allowed; a finite number from 0 to 10; lower it"),
        ({"position": {"bias_m": [1]}}, "errors.position.bias_m"),
        ({"antenna": {"encoder_step_deg": 46}}, "errors.antenna.encoder_step_deg: 46 is not allowed"),
        ({"feed": {"drop_rate": 1.1}}, "errors.feed.drop_rate: 1.1 is not allowed; a finite number from 0 to 1; lower it"),
        ({"feed": {"burst_spokes": 2.5}}, "errors.feed.burst_spokes: 2.5 is not allowed"),
        ({"feed": {"heading_lost_s": [[5, 5]]}}, "heading_lost_s[0]: 5 s is not after 5 s; give from and to in this order"),
        ({"feed": {"bytes_per_s": 0}}, "errors.feed.bytes_per_s: 0 is not allowed"),
        (
            {"profile": "imo"},
            'errors.profile: "imo" is not allowed; one of "imo-a823", "imo-2004", "msc116-thd"; choose one of these',
        ),
        ({"compass": {}}, "errors.compass: this is not a known key"),
        (3, "errors: 3 is not allowed"),
    ],
)
def test_what_is_not_allowed_is_refused_with_a_sentence(errors: Any, message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene({"errors": errors})
    assert message in str(refused.value)
