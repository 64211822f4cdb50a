"""Structures in scene files: what they become, and what is refused."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from tests.scenes import radar

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
