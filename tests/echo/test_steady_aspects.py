"""Ships that hardly turn from scan to scan keep what was traced of them, whatever was computed before."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.beam_passage import BeamPassages
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import fidelity_from_name
from radar_service.scattering.physical_optics.optical_body import OpticalBody
from tests.scattering.physical_optics.test_illumination import error

SCENES = Path(__file__).parents[2] / "scenes"
ABEAM = {"position_m": [300.0, 3000.0, 0.0], "course_deg": 10.0, "speed_kn": 8.0}  # turns by 0.03 degrees a scan
SWAY = {"roll_deg": 3.0, "roll_period_s": 8.0}


def passages(
    fidelity: str = "balanced", own_ship: dict[str, Any] | None = None, step: float | None = None, **keys: Any
) -> BeamPassages:
    """A metal body under way 3 km off in a sea that reflects; step: between traces [deg], None: that of the fidelity."""
    table = {
        "radar": {"range_max_m": 5000, "height_m": 15, "azimuths": 1024, "rpm": 24, "beamwidth_deg": 1.2},
        "environment": {"multipath": True},
        "own_ship": own_ship or {},
        "body": [{"name": "body", "scattering": "optics", "mesh": "coaster.obj"} | ABEAM | keys],
    }
    chosen = fidelity_from_name(fidelity)
    chosen = chosen if step is None else replace(chosen, trace_step_deg=step)
    return prepare(rs.load_scene(table, folder=SCENES), chosen, 3).moving.passages


def node(made: BeamPassages, scan: int) -> int:
    """The only node of a passage."""
    (spoke,) = made.nodes(0, made.crossing(0, scan + 0.02))
    return int(spoke)


@pytest.mark.parametrize(("keys", "fewest", "most"), [
    ({}, 1, 3), ({"course_deg": 100.0, "speed_kn": 30.0}, 0, 0), (SWAY, 0, 0), ({"fidelity": "reference"}, 0, 0),
    ({"own_ship": SWAY}, 0, 0), ({"position_m": [50.0, 600.0, 0.0], "speed_kn": 0.02}, 0, 0),
], ids=["steady", "turns by 0.7 degrees", "sways", "reference", "own ship sways", "near"])  # fmt: skip
def test_a_ship_that_turns_little_is_traced_once_in_many_scans(
    keys: dict[str, Any], fewest: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 8 knots in 8 scans of 2.5 s it goes 80 m: past one or two steps of distance, 87 and 260 m, or of aspect. Others are
    evaluated without a trace for more than one scan."""
    made, traced, anew = passages(**keys), [], []
    illuminated, echoes = OpticalBody.illuminated, OpticalBody.echoes
    monkeypatch.setattr(OpticalBody, "illuminated", lambda *given: traced.append(1) or illuminated(*given))
    monkeypatch.setattr(OpticalBody, "echoes", lambda *given: anew.append(1) or echoes(*given))
    scans = 8 if most else 2
    for scan in range(scans):
        made.evaluated(0, int(made.nodes(0, made.crossing(0, scan + 0.02))[0]), 0.0)
    assert fewest <= len(traced) <= most and len(anew) == (0 if most else scans)


def test_what_is_kept_depends_on_the_aspect_alone() -> None:
    """Scans in order, in reverse, and one alone: the same bytes."""
    order = [0, 1, 2, 3, 4, 5]
    results = []
    for scans in (order, order[::-1]):
        made = passages()
        results.append({scan: made.evaluated(0, node(made, scan), 0.0) for scan in scans})
    alone = passages()
    results.append({4: alone.evaluated(0, node(alone, 4), 0.0)})
    for one in results[1:]:
        for scan, observed in one.items():
            for name in ("position", "amplitude", "path"):
                first = getattr(results[0][scan].echoes, name)
                np.testing.assert_array_equal(getattr(observed.echoes, name), first)


def test_what_is_kept_is_near_what_is_traced_anew() -> None:
    """Within 0.2 at most aspects (docs/decisions/0021-shared-traces.md), as what runs of nodes share; of five scans with rounded
    aspects of their own."""
    kept, anew = passages(), passages(step=0.0)
    errors = []
    for scan in range(0, 20, 4):
        spoke = node(kept, scan)
        errors.append(error(kept.evaluated(0, spoke, 0.0), anew.evaluated(0, spoke, 0.0)))
    assert 0.0 < float(np.median(errors)) < 0.2
