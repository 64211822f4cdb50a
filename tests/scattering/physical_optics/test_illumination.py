"""What is kept of a trace: it gives the same fields at the same pose, and the sea cuts it wherever it stands."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.passage_traces import TraceRun
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import fidelity_from_name
from radar_service.scattering.physical_optics.illumination import lift
from tests.scattering.physical_optics.meshes import dihedral, write_obj

SCENES = Path(__file__).parents[3] / "scenes"
STEEP = 4.0  # m, half the shortest wave that sums are weighted by


SHIP = {"mesh": "coaster.obj", "course_deg": 40.0, "position_m": [0, 300, 0]}
BOX = {"shape": "box", "length_m": 24.0, "width_m": 6.0, "height_m": 6.0, "course_deg": 80.0, "position_m": [0, 300, 0]}
HULL = {"shape": "hull", "length_m": 24.0, "beam_m": 6.0, "height_m": 6.0, "course_deg": 80.0, "position_m": [0, 300, -1]}


def passages_of(
    body: dict[str, Any], fidelity: str = "balanced", folder: Path = SCENES, bounces: int = 3, **keys: Any
) -> BeamPassages:
    """Of a metal body under way 300 m off in a sea that reflects."""
    table = {
        "radar": {"range_max_m": 900, "height_m": 15, "azimuths": 512, "rpm": 24},
        "environment": {"multipath": True},
        "body": [{"name": "body", "scattering": "optics", "speed_kn": 1.0} | body | keys],
    }
    chosen = replace(fidelity_from_name(fidelity), bounces=bounces)
    return prepare(rs.load_scene(table, folder=folder), chosen, 3).moving.passages


def by_path(observed: ObservedEchoes) -> dict[int, NDArray[np.complex128]]:
    """Sums of the amplitudes of each path, weighted by waves over the body whose halves are no shorter than STEEP."""
    waves = np.random.default_rng(1).uniform(-np.pi / STEEP, np.pi / STEEP, (200, 3))
    path, amplitude = observed.echoes.path, observed.echoes.amplitude
    weights = np.exp(1j * waves @ (observed.position - [0.0, 300.0, 0.0]).T)
    return {ways: weights[:, path == ways] @ amplitude[path == ways] for ways in set(path.tolist())}


def error(got: ObservedEchoes, exact: ObservedEchoes) -> float:
    """Difference of the sums of all paths, relative."""
    first, second = by_path(got), by_path(exact)
    assert first.keys() == second.keys()
    apart = sum(float(np.linalg.norm(first[path] - second[path]) ** 2) for path in second)
    return float(np.sqrt(apart / sum(float(np.linalg.norm(sums) ** 2) for sums in second.values())))


@pytest.mark.parametrize(("roll", "bounces"), [(0.0, 3), (7.0, 3), (7.0, 1), (0.0, 5)])
def test_at_the_pose_of_the_trace_what_is_kept_is_what_is_traced(roll: float, bounces: int) -> None:
    """But for tubes that were cut at an edge: each part gets a ray of its own, where the trace has that of the whole tube. Their
    directions differ by half a tube over the distance, 1 mrad, which is 0.2 rad over a tube of 1 m, and of a few tubes alone."""
    rolling = {"roll_deg": roll, "roll_period_s": 9.0, "roll_phase_deg": 50.0} if roll else {}
    passages = passages_of(SHIP, bounces=bounces, **rolling)
    now = 82
    assert error(passages.evaluated(0, now, 0.0, TraceRun(now, (now,))), passages.evaluated(0, now, 0.0)) < 2e-3


@pytest.mark.parametrize(("earlier", "until"), [(20, 717), (102, 717), (20, 740), (102, 740)])
def test_the_sea_cuts_what_was_traced_above_it(earlier: int, until: int) -> None:
    """A heaving hull, traced when she was deeper, as high as at one of two instants. Her facets are cut exactly, but otherwise
    than by a trace of the same pose, so their sums with waves over the hull differ by -30 dB."""
    passages, high = passages_of(HULL, heave_m=0.5, heave_period_s=4.0), 717  # spokes of 4.9 ms; she is deepest at 3 s
    low = high - earlier
    exact = passages.evaluated(0, high, 0.0)
    kept, cut_too_high = (
        error(passages.evaluated(0, high, 0.0, TraceRun(low, nodes)), exact) for nodes in ((high, until), (low,))
    )
    assert kept < 0.05 and cut_too_high > 5.0 * kept


def test_bounces_below_the_sea_count_no_more_than_in_a_trace(tmp_path: Path) -> None:
    """Two plates that stand in the sea, 3.3 m above it, and rise by 0.12 m until another node."""
    write_obj(tmp_path / "plates.obj", dihedral(3.0, 6.0, 2))
    passages = passages_of(
        {"mesh": "plates.obj", "course_deg": 135.0, "position_m": [0, 300, 0]},
        "balanced",
        tmp_path,
        heave_m=0.5,
        heave_period_s=4.0,
    )
    low, high = 650, 717
    exact, kept = (by_path(passages.evaluated(0, low, 0.0, run)) for run in (None, TraceRun(low, (low, high))))
    assert abs(np.vdot(exact[1], kept[1]) / np.vdot(exact[1], exact[1])) == pytest.approx(1.0, abs=0.04)


def test_what_shares_a_trace() -> None:
    """Ships in a seaway; no body whose parts do not face each other, and nothing in `reference`."""
    rolling = {"roll_deg": 3.0, "roll_period_s": 9.0}
    shared = {}
    for name, body, fidelity in (("ship", SHIP, "balanced"), ("exact", SHIP, "reference"), ("box", BOX, "balanced")):
        passages = passages_of(body, fidelity, **rolling)
        crossing = passages.crossing(0, 1.0)
        assert len(passages.nodes(0, crossing)) > 3
        shared[name] = passages.runs(0, crossing)
    assert shared["ship"] and not shared["exact"] and not shared["box"]


def test_a_ship_within_whose_radius_the_antenna_is_shares_no_trace() -> None:
    """Her house turns otherwise than her middle."""
    runs = {}
    for north in (30.0, 120.0):
        passages = passages_of(SHIP | {"position_m": [0, north, 0]}, roll_deg=3.0, roll_period_s=9.0)
        runs[north] = passages.runs(0, passages.crossing(0, 1.0))
    assert not runs[30.0] and runs[120.0]


def test_a_body_is_lifted_by_what_its_waterline_sinks() -> None:
    box = np.array([[-2.0, -9.0, -1.0], [2.0, 9.0, 5.0]])
    level = np.repeat(np.eye(3)[None], 2, axis=0)
    heave = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.3]])
    assert lift(box, heave, level) == pytest.approx(0.3)
    assert lift(box, heave[::-1], level) == 0.0, "it sinks"
    assert lift(box + [0.0, 0.0, 3.0], heave, level) == 0.0, "the sea does not wet it"
    roll = np.deg2rad(4.0)
    leaning = level.copy()
    leaning[1] = [[np.cos(roll), 0, np.sin(roll)], [0, 1, 0], [-np.sin(roll), 0, np.cos(roll)]]
    highest = max(x * -np.sin(roll) + z * (np.cos(roll) - 1) for x in (-2.0, 2.0) for z in (-1.0, 5.0))
    assert lift(box, np.zeros((2, 3)), leaning) == pytest.approx(highest)
