"""What is kept of a trace: it gives the same fields at the same pose, and the sea cuts it wherever it stands."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.preparation import prepare
from radar_service.numerics.types import Floats
from radar_service.records.fidelity import fidelity_from_name
from radar_service.scattering.model import BodyEchoes, Instant
from radar_service.scattering.physical_optics.illumination import lift, share_above
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.scattering.physical_optics.triangle_cuts import cut

SCENES = Path(__file__).parents[3] / "scenes"
STEEP = 4.0  # m, half the shortest wave that sums are weighted by


SHIP = {"mesh": "coaster.obj", "course_deg": 40.0, "position_m": [0, 300, 0]}
HULL = {"shape": "hull", "length_m": 24.0, "beam_m": 6.0, "height_m": 6.0, "course_deg": 80.0, "position_m": [0, 300, -1]}


def prepared(body: dict[str, Any], **keys: Any) -> tuple[PhysicalOptics, rs.Scene, Any]:
    """A metal body under way 300 m off in a sea that reflects, as its model has it."""
    table = {
        "radar": {"range_max_m": 900, "height_m": 15, "azimuths": 64, "beamwidth_deg": 12},
        "environment": {"multipath": True},
        "body": [{"name": "body", "scattering": "optics", "speed_kn": 1.0} | body | keys],
    }
    made = rs.load_scene(table, folder=SCENES)
    passages = prepare(made, fidelity_from_name("balanced"), 3).moving.passages
    (aspect,) = passages._aspects
    assert isinstance(aspect.model, PhysicalOptics)
    return aspect.model, made, passages


def instant(made: rs.Scene, passages: Any, time: float) -> tuple[Floats, Instant]:
    return made.antenna(time)[0], Instant(time, passages._line_of_sight, passages._max_range)


def by_path(echoes: BodyEchoes) -> dict[int, NDArray[np.complex128]]:
    """Sums of the amplitudes of each path, weighted by waves over the body whose halves are no shorter than STEEP."""
    waves = np.random.default_rng(1).uniform(-np.pi / STEEP, np.pi / STEEP, (200, 3))
    weights = np.exp(1j * waves @ echoes.position.T)
    return {
        path: weights[:, echoes.path == path] @ echoes.amplitude[echoes.path == path] for path in set(echoes.path.tolist())
    }


def error(got: BodyEchoes, exact: BodyEchoes) -> float:
    """Difference of the sums of all paths, relative."""
    first, second = by_path(got), by_path(exact)
    assert first.keys() == second.keys()
    apart = sum(float(np.linalg.norm(first[path] - second[path]) ** 2) for path in second)
    return float(np.sqrt(apart / sum(float(np.linalg.norm(sums) ** 2) for sums in second.values())))


@pytest.mark.parametrize("roll", [0.0, 7.0])
def test_at_the_pose_of_the_trace_what_is_kept_is_what_is_traced(roll: float) -> None:
    """But for tubes that were cut at an edge: each part gets a ray of its own, where the trace has that of the whole tube. Their
    directions differ by half a tube over the distance, 1 mrad, which is 0.2 rad over a tube of 1 m, and of a few tubes alone."""
    rolling = {"roll_deg": roll, "roll_period_s": 9.0, "roll_phase_deg": 50.0} if roll else {}
    model, made, passages = prepared(SHIP, **rolling)
    antenna, now = instant(made, passages, 0.4)
    trace = model.traced(0, antenna, now, np.array([0.4]))
    assert trace is not None and sum(group.corners.shape[2] for group in trace.tubes) > 1000
    assert error(model.body_echoes(0, antenna, now, trace), model.body_echoes(0, antenna, now)) < 2e-3


@pytest.mark.parametrize("earlier", [0.1, 0.5])
def test_the_sea_cuts_what_was_traced_above_it(earlier: float) -> None:
    """A heaving hull, traced when she was deeper. Her facets are cut exactly, but otherwise than by a trace of the same pose, so
    their fields are shared otherwise among the centres of a lattice."""
    model, made, passages = prepared(HULL, heave_m=0.5, heave_period_s=4.0)
    antenna, high = instant(made, passages, 3.5)
    _, low = instant(made, passages, 3.5 - earlier)
    trace, dry = (model.traced(0, antenna, low, np.array([until])) for until in (3.5, low.time))
    exact = model.body_echoes(0, antenna, high)
    kept, cut_too_high = (error(model.body_echoes(0, antenna, high, each), exact) for each in (trace, dry))
    assert kept < 1e-3 and cut_too_high > 10.0 * kept


def test_reference_traces_each_aspect() -> None:
    made = prepared(SHIP)[1]
    passages = prepare(made, fidelity_from_name("reference"), 3).moving.passages
    assert passages._aspects[0].model.trace_step(0) == 0.0


def test_the_share_above_a_level_is_that_of_the_parts_that_rise_above_it() -> None:
    rng = np.random.default_rng(4)
    corners = rng.normal(size=(500, 3, 3))
    (parts, origin), _ = cut(corners, corners[:, :, 2])
    area, whole = (
        np.linalg.norm(np.cross(some[:, 1] - some[:, 0], some[:, 2] - some[:, 0]), axis=1) for some in (parts, corners)
    )
    expected = np.bincount(origin, area, minlength=500) / whole
    np.testing.assert_allclose(share_above(corners[:, :, 2].T), expected, atol=1e-12)
    assert share_above(np.array([[0.0], [0.0], [0.0]])) == 1.0 and share_above(np.array([[0.0], [-1.0], [0.0]])) == 0.0


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
