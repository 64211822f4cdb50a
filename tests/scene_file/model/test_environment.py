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
        ({"sea_state": 10}, "environment.sea_state: 10 is not allowed; a whole number from 0 to 9"),
    ],
)
def test_what_does_not_go_together_is_refused(environment: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene({"environment": environment})
    assert message in str(refused.value)
