"""What structures take: edges in closed form."""

import numpy as np
import pytest

from radar_service.stages.structures.structure import Structure, fresnel_unit, taken

WAVELENGTH = 0.0319
MIDDLE = np.zeros(1)


def test_half_the_field_is_left_at_the_edge_of_a_shadow() -> None:
    """Behind a wide structure whose edge is straight ahead the field is 1/2; at its top too, and a quarter at both together."""
    distance, radius = 60.0, 30.0
    aside = np.array([np.arcsin(radius / distance)])
    for top, left in ((np.inf, 0.5), (0.0, 0.75)):
        field = 1.0 - taken(Structure("wall", 0.0, distance, radius, top), WAVELENGTH, aside, MIDDLE)[0, 0]
        far_edge = 1.0 / (np.pi * 2.0 * radius / fresnel_unit(WAVELENGTH, distance * np.cos(aside[0])))  # what it still adds
        assert abs(field - left) < far_edge


@pytest.mark.parametrize("below", [0.5, 1.0, 2.0])
def test_a_top_below_the_beam_is_a_knife_edge(below: float) -> None:
    """Loss behind a screen whose top is over the way by so many Fresnel units: ITU-R P.526-15, eq. 31, which errs by 0.1 dB."""
    distance, radius = 20.0, 15.0
    unit = float(fresnel_unit(WAVELENGTH, distance))
    wall = Structure("wall", 0.0, distance, radius, below * unit)
    lit = 1.0 - taken(wall, WAVELENGTH, np.zeros(1), MIDDLE)[0, 0]
    loss_db = 6.9 + 20.0 * np.log10(np.sqrt((below - 0.1) ** 2 + 1.0) + below - 0.1)
    sides_db = 20.0 * np.log10(1.0 + 2.0 / (np.pi * radius / unit) / abs(lit))  # what its two side edges let pass
    assert abs(20.0 * np.log10(abs(lit)) + loss_db) < 0.1 + sides_db
    assert sides_db < 2.0


def test_nothing_is_taken_far_from_the_structure() -> None:
    mast = Structure("mast", 0.0, 3.0, 0.1)
    assert abs(taken(mast, WAVELENGTH, np.radians([75.0]), MIDDLE)[0, 0]) < 1e-30
    assert abs(taken(mast, WAVELENGTH, np.zeros(1), MIDDLE)[0, 0]) > 0.5
