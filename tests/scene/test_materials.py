"""Materials by name."""

import pytest

from radar_service.scene.error import SceneError
from radar_service.scene.materials import MATERIALS, material_from_name


def test_gammas_are_power_ratios_in_the_ladder_of_land() -> None:
    assert MATERIALS["sand"].gamma == pytest.approx(0.01)  # -20 dB, flat ground
    assert MATERIALS["sand"].gamma < MATERIALS["land"].gamma < MATERIALS["urban"].gamma < MATERIALS["rock"].gamma
    assert all(name == material.name and 0.0 < material.gamma <= 1.0 for name, material in MATERIALS.items())


def test_metals_scatter_by_optics_and_nothing_else_does() -> None:
    assert {name for name, material in MATERIALS.items() if material.scattering == "optics"} == {"steel", "aluminium"}


def test_unknown_material_lists_all() -> None:
    with pytest.raises(SceneError) as caught:
        material_from_name("steal", "body[2].material")
    text = str(caught.value)
    assert text.startswith('body[2].material: "steal" is not a known material; one of ')
    assert all(name in text for name in MATERIALS)
