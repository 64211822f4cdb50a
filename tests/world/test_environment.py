"""The environment of an empty scene: the standard earth, and no other effect."""

from radar_service.world.environment import Environment
from tests.scenes import scene


def test_all_effects_are_off_by_default() -> None:
    assert scene().environment == Environment(
        earth_factor=4 / 3, noise=False, multipath=False, gas_db_per_km=0.0, rain_mm_h=0.0, sea_state=0,
        effect_keys={"sea_texture_shape": None}, wind_from=0.0, ground_plane=False,
    )  # fmt: skip
    assert scene().effects == {}
