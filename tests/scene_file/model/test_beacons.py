"""Models of beacons: what their defaults are, and that they are sections of a body's table."""

import pytest
from pydantic import ValidationError

from radar_service.scene_file.model.beacons import RaconModel, SartModel


def test_defaults() -> None:
    """A fifth of 10 NM, -50 dBm at the antenna, a SART's 400 mW (M.628)."""
    racon, sart = RaconModel(letter="K"), SartModel()
    assert racon.mark_m == 0.2 * 10 * 1852 and racon.sensitivity_dbm == sart.sensitivity_dbm == -50.0
    assert 10 ** (sart.power_dbm / 10) == pytest.approx(400, rel=0.01)


@pytest.mark.parametrize("keys", [{"letter": "K", "color": 1}, {"letter": "ABCD"}, {"letter": "K", "delay_s": -1e-9}])
def test_what_is_refused(keys: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        RaconModel.model_validate(keys)
