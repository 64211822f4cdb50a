"""Budgets over a whole run: late, at the closest approach, and where motion, sea, shadow and turn meet.

Against `reference` on the same points, whose metal is tested against independent oracles (tests/reference), with the aspect of
each azimuth.
"""

import functools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.beam_passage import BeamPassages
from radar_service.numerics.constants import KNOT
from radar_service.plan.body_errors import aspects_db
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.plan import plan_for
from radar_service.plan.settings_search import fidelity_for
from radar_service.records.fidelity import PRESETS, Fidelity
from tests.plan.scenes import made
from tests.plan.test_body_errors import every_azimuth
from tests.scenes import point

BUDGET = ErrorBudget()
SEA = {"environment": {"multipath": True}}
FINE = {"azimuths": 180, "beamwidth_deg": 7.8, "range_max_m": 1400}
SPEED = 40 * KNOT
LOBE = 0.05  # of the range: an echo in a null is judged by the rms field within so much of it


def scans(scene: rs.Scene, fidelity: Fidelity, numbers: range) -> list[np.ndarray[Any, Any]]:
    """The fields of some scans."""
    fields, sim = [], rs.Simulator(scene, fidelity)
    for number in numbers:
        sim.skip_to(number)
        fields.append(sim.scan().field)
    return fields


def exact(chosen: Fidelity) -> Fidelity:
    """`reference` on the points and in the visibility steps of a fidelity."""
    kept = {name: getattr(chosen, name) for name in ("scatterers_per_cell", "min_scatterers", "visibility_step")}
    return replace(PRESETS["reference"], **kept)


def energy(field: np.ndarray[Any, Any]) -> float:
    return float(np.sum(np.abs(field) ** 2))


def lobe_energy(scene: rs.Scene, scan: int) -> float:
    """Mean energy of the first scans of 11 scenes whose target starts within LOBE of where it is in the middle of a scan."""
    radar, (body,) = scene.radar, scene.bodies
    place = body.motion.pose((scan + 0.5) * radar.rotation_period).position[0]
    energies = []
    for share in np.linspace(1.0 - LOBE, 1.0 + LOBE, 11):
        at = point("t", float(place[0]), float(place[1]) * share, float(place[2]), 20)
        energies.append(energy(rs.Simulator(made([at], FINE, **SEA), PRESETS["balanced"]).scan().field))
    return float(np.mean(energies))


def approach(height: float) -> rs.Scene:
    """A point that passes 60 m off at 40 kn, from 1200 to 80 m (5.3 antenna heights), through lobes and nulls."""
    return made([point("t", 60, 1300, height, 20, speed_kn=40, course_deg=180)], FINE, **SEA)


APPROACH = range(2, 25, 4)


@functools.cache
def exact_approach(height: float) -> tuple[list[np.ndarray[Any, Any]], list[float]]:
    """The fields of `reference` in an approach, and their energies."""
    scene = approach(height)
    fields = scans(scene, exact(fidelity_for(scene, BUDGET)), APPROACH)
    return fields, [energy(field) for field in fields]


def misses_budget(height: float, **change: float) -> Iterator[bool]:
    """Whether each scan of an approach misses the budget, relative to its field and, as it may be in a null, to its lobe's."""
    scene, (fields, energies) = approach(height), exact_approach(height)
    allowed = 10 ** (BUDGET.field_db / 10)
    planned = scans(scene, replace(fidelity_for(scene, BUDGET), **change), APPROACH)
    for number, a, exactly, own in zip(APPROACH, planned, fields, energies, strict=True):
        error = energy(a - exactly)
        yield error >= allowed * own and error >= allowed * lobe_energy(scene, number)


@pytest.mark.parametrize("height", [2.0, 8.0])
def test_a_fast_approach_over_the_sea_keeps_the_budget_at_every_range(height: float) -> None:
    """-40 dB."""
    assert not any(misses_budget(height))


def test_a_shorter_beam_misses_the_budget_in_this_approach() -> None:
    assert any(misses_budget(2.0, beam_extent=3.0))


def test_power_is_that_of_reference_out_of_nulls() -> None:
    """0.5 dB, at each scan whose echo is not 10 dB below its lobe."""
    numbers = APPROACH[::2]
    scene, (_, energies) = approach(8.0), exact_approach(8.0)
    for a, exactly in zip(scans(scene, fidelity_for(scene, BUDGET), numbers), energies[::2], strict=True):
        assert abs(10 * np.log10(energy(a) / exactly)) < BUDGET.target_db


STEEL = {"material": "steel", "scattering": "optics"}
SCREEN = {"name": "screen", "shape": "box", "length_m": 30, "width_m": 6, "height_m": 6, "rcs_dbsm": 25,
          "position_m": [-40, 260, 0], "heading_deg": 90, "speed_kn": 10, "course_deg": 90}  # fmt: skip
BARGE = {"name": "barge", "shape": "box", "length_m": 8, "width_m": 4, "height_m": 5} | STEEL
TURN = {"position_m": [-25, 420, 0],
        "waypoints": [{"position_m": [5, 420], "speed_kn": 8}, {"position_m": [40, 380], "speed_kn": 8}]}  # fmt: skip
OWN = {"own_ship": {"waypoints": [{"position_m": [20, 25], "speed_kn": 12}, {"position_m": [80, 20], "speed_kn": 12}]}}
COMBINED: dict[str, tuple[list[dict[str, Any]], dict[str, Any]]] = {
    "passing metal over the sea": ([BARGE | {"position_m": [-40, 300, 0], "speed_kn": 12, "course_deg": 90}], SEA),
    "turning metal in a passing shadow": ([BARGE | TURN, SCREEN], {}),
    "turning metal in a passing shadow over the sea": ([BARGE | TURN, SCREEN], SEA),
    "metal and a shadow from a ship that turns": ([BARGE | {"position_m": [0, 400, 0]}, SCREEN], SEA | OWN),
}


PARTS = ("passing metal over the sea", "turning metal in a passing shadow")  # of the next one of COMBINED


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.study) if name in PARTS else name for name in COMBINED]
)
def test_movement_sea_shadow_and_turn_together_keep_the_budget(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The predicted error of the plan in each scan about the closest approach, and 0.5 dB of its power."""
    bodies, sections = COMBINED[name]
    scene = made(bodies, FINE | {"range_max_m": 600}, **sections)
    chosen, numbers = fidelity_for(scene, BUDGET), range(4, 5)
    predicted = plan_for(scene, chosen).field_db
    assert aspects_db(scene) in predicted.values()
    fields = scans(scene, chosen, numbers)
    monkeypatch.setattr(BeamPassages, "_scheduled", every_azimuth)
    for a, e in zip(fields, scans(scene, exact(chosen), numbers), strict=True):
        error = 10 * np.log10(energy(a - e) / energy(e))
        assert error < 20 * np.log10(sum(10 ** (one / 20) for one in predicted.values()))
        assert abs(10 * np.log10(energy(a) / energy(e))) < BUDGET.target_db
