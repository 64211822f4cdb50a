"""Materials by name."""

import pytest

from radar_service.world.error import SceneError
from radar_service.world.materials import MATERIALS, material_from_name, power_reflectivity


def test_gammas_are_power_ratios_in_the_ladder_of_land() -> None:
    assert MATERIALS["sand"].gamma == pytest.approx(0.01)  # -20 dB, flat ground
    assert MATERIALS["sand"].gamma < MATERIALS["land"].gamma < MATERIALS["urban"].gamma < MATERIALS["rock"].gamma
    assert all(name == material.name and 0.0 < material.gamma <= 1.0 for name, material in MATERIALS.items())


def test_only_metals_scatter_by_optics() -> None:
    assert {name for name, material in MATERIALS.items() if material.scattering == "optics"} == {"steel", "aluminium"}


def test_unknown_material_lists_all() -> None:
    with pytest.raises(SceneError) as caught:
        material_from_name("steal", "body[2].material")
    text = str(caught.value)
    assert text.startswith('body[2].material: "steal" is not a known material; one of ')
    assert all(name in text for name in MATERIALS)


def test_every_material_has_its_reflectivity() -> None:
    """Metals all of it, nothing else half; concrete as its permittivity says: ((sqrt 5.24 - 1) / (sqrt 5.24 + 1))^2, to the
    digit its decibels are given with."""
    shares = {name: power_reflectivity(name) for name in MATERIALS}
    assert shares["steel"] == shares["aluminium"] == 1.0
    assert all(0.0 < share < 0.5 for name, share in shares.items() if MATERIALS[name].scattering != "optics")
    assert shares["concrete"] == pytest.approx(((5.24**0.5 - 1) / (5.24**0.5 + 1)) ** 2, rel=0.012)
