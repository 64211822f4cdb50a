"""The environment of a scene file: effects that need each other."""

from typing import Any

import pytest

import radar_service as rs


@pytest.mark.parametrize(
    ("environment", "message"),
    [
        ({"diffraction": True}, "environment.diffraction: true needs the sea's reflection; give multipath = true"),
        ({"diffraction": True, "multipath": True, "earth": "flat"}, "environment.diffraction: true needs a round earth"),
        ({"diffraction": True, "multipath": True, "earth": 1000.0}, "needs a round earth, not earth = 1000.0; give 4/3"),
        ({"earth": "round"}, 'environment.earth: "round" is not allowed'),
        ({"sea_state": 10}, "environment.sea_state: 10 is not allowed; a finite number from 0 to 9; lower it"),
        ({"sea_state": -0.5}, "environment.sea_state: -0.5 is not allowed; a finite number from 0 to 9; raise it"),
        (
            {"sea_state": 0, "wave_height_m": 1.04},
            "environment.wave_height_m: sea_state is given too; give one, as sea_state = 2.99",
        ),
        ({"wave_height_m": 11.0}, "environment.wave_height_m: 11 is not allowed; a finite number from 0.05 to 10; lower it"),
        (
            {"sea_texture_shape": 0.01},
            "environment.sea_texture_shape: 0.01 is not allowed; a finite number from 0.05 to 1000; raise it",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(environment: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene({"environment": environment})
    assert message in str(refused.value)


def test_a_sea_is_given_by_state_or_by_wave_height() -> None:
    assert rs.load_scene({"environment": {"sea_state": 2.5}}).environment.sea_state == 2.5
    environment = rs.load_scene({"environment": {"wave_height_m": 2.977, "seaway": True}}).environment
    assert environment.sea_state == pytest.approx(5.0, abs=1e-3)
    assert environment.seaway is not None and environment.seaway.height == pytest.approx(2.977, rel=1e-9)
