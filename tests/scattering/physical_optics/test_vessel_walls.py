"""What `check` says of the walls of vessels."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scattering.physical_optics.plating import dark_share, upright_share, upright_warnings
from tests.scattering.physical_optics.test_mesh_quality import judged

UPRIGHT, DARK = "upright, over a reflecting sea", "flat plates: echo at broadside alone"
HULL = {"shape": "hull", "length_m": 60.0, "beam_m": 11.0, "height_m": 10.0}


def remarks(*, sea: bool = True, folder: Path | None = None, environment: dict[str, Any] | None = None, **body: Any) -> str:
    """Of one body by physical optics."""
    table = {"name": "b", "position_m": [0, 1500, 0], "scattering": "optics", **body}
    scene = rs.load_scene({"environment": {"multipath": sea, **(environment or {})}, "body": [table]}, folder=folder)
    return "\n".join([*judged(scene)["b"], *upright_warnings(scene.bodies, scene.environment)])


def test_plain_hulls_are_upright_and_dark_and_other_types_neither() -> None:
    plain = remarks(**HULL)
    assert UPRIGHT in plain and "seaway = true" in plain and DARK in plain and "hull_type" in plain
    for hull_type in ("cargo", "ferry", "fishing", "yacht", "pilot"):
        other = remarks(**HULL, hull_type=hull_type)
        assert UPRIGHT not in other and DARK not in other


@pytest.mark.parametrize(
    "change",
    [{"sea": False}, {"environment": {"sea_state": 3, "seaway": True}}, {"list_deg": 1.0}, {"material": "wood"}],
)
def test_the_corner_with_the_sea_is_gone(change: dict[str, Any]) -> None:
    """Over no sea, in a seaway, with a list, and of a material that hardly reflects."""
    assert UPRIGHT not in remarks(**HULL, **change)


def test_a_shipped_mesh_is_upright_but_not_dark() -> None:
    text = remarks(folder=Path(rs.__file__).parents[1] / "scenes", mesh="coaster.obj")
    assert UPRIGHT in text and DARK not in text


def test_many_upright_vessels_are_one_sentence() -> None:
    hulls = [{**HULL, "name": f"h{k}", "position_m": [300 * k, 1500, 0], "scattering": "optics"} for k in range(4)]
    scene = rs.load_scene({"environment": {"multipath": True}, "body": hulls})
    (text,) = upright_warnings(scene.bodies, scene.environment)
    assert text.startswith("h0, h1 and 2 more: metal, upright, over a reflecting sea: ")


def test_bodies_that_are_no_vessels_are_left_alone() -> None:
    text = remarks(shape="box", length_m=20.0, width_m=5.0, height_m=5.0)
    assert UPRIGHT not in text and DARK not in text


def test_shares_of_walls_whose_answers_are_known() -> None:
    """A box faces 4 of 36 sectors of 10 degrees, to an aspect or two; half its area leans by 1 degree."""
    angle = np.deg2rad([10.0, 100.0, 190.0, 280.0])
    box = np.column_stack([np.sin(angle), np.cos(angle), np.zeros(4)])
    assert dark_share(box) == pytest.approx(1.0 - 4.0 * 10.0 / 360.0, abs=0.006)
    assert dark_share(box[:1]) == pytest.approx(1.0 - 10.0 / 360.0, abs=0.003)
    leaning = box.copy()
    leaning[:2, 2] = np.sin(np.deg2rad(1.0))
    assert upright_share(leaning, np.array([3.0, 2.0, 4.0, 1.0])) == pytest.approx(0.5)
