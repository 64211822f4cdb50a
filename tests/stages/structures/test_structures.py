"""The short modules of stages/structures, each under its name."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.stages.structures.structure import Structure, fresnel_unit, taken
from tests.scenes import radar

# effect: structures in scene files: what they become, and what is refused.
MAST = {"name": "mast", "bearing_deg": -10, "distance_m": 3.0, "width_m": 0.4}


def test_a_structure_in_si_units() -> None:
    (mast, low) = radar(structure=[MAST, {**MAST, "bearing_deg": 170, "top_m": 0.5, "reflection": 0.3}]).effects[
        "structures"
    ]
    assert (mast.name, mast.distance, mast.radius, mast.top, mast.reflection) == ("mast", 3.0, 0.2, np.inf, 1.0)
    assert mast.bearing == pytest.approx(np.radians(-10))
    assert (low.top, low.reflection) == (0.5, 0.3)


@pytest.mark.parametrize(
    "settings, message",
    [
        ({"structure": [{**MAST, "distance_m": 0.3}]}, r"structure\[0\].distance_m: 0.3 m; the antenna of 0.415 m would strike"),
        ({"structure": [{**MAST, "width_m": 0}]}, r"radar.structure\[0\].width_m: .*0.01"),
        ({"structure": [{**MAST, "reflection": 1.5}]}, r"radar.structure\[0\].reflection: .*1"),
        ({"structure": [{**MAST, "material": "steel"}]}, r"radar.structure\[0\].material"),
        ({"structure": [MAST, {**MAST, "bearing_deg": 352}]}, r"structure\[1\].bearing_deg: 352 is 2 degrees from .* 7.6"),
        ({"structure": [MAST], "pattern": "gaussian"}, r'structure: pattern gaussian has no aperture .* "sinc2", "taylor"'),
        ({"structure": [MAST], "pattern": [[0, 0], [4, -20]]}, r"structure: pattern a table of 2 rows"),
    ],
)  # fmt: skip
def test_impossible_structures_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        radar(**settings)


# structure: what structures take: edges in closed form.
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
