"""Bodies that come and go, against scenes that have them always or never."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine.documented import DocumentedEngine
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import Fidelity, fidelity_from_name
from radar_service.simulator import Simulator
from tests.scenes import point, scene

RADAR = {"range_max_m": 600, "azimuths": 64, "beamwidth_deg": 12, "pulse_s": 1e-6, "rpm": 60}
GRID_DB = -50.0  # moving echoes err by -56 dB (docs/engine.md#errors): blocks of other lengths err otherwise
SHIP = {"shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 9, "heading_deg": 80, "course_deg": 80, "speed_kn": 0.5}
WALL = {"name": "wall", "shape": "box", "length_m": 10, "width_m": 300, "height_m": 6, "position_m": [0, 400, 0],
        "material": "concrete"}  # fmt: skip


def whole_scan(made: rs.Scene, scan: int, fidelity: str | Fidelity = "balanced") -> np.ndarray[Any, Any]:
    """The field of one scan."""
    chosen = fidelity_from_name(fidelity) if isinstance(fidelity, str) else fidelity
    return np.concatenate([field for _, field, _ in Engine(prepare(made, chosen, 3)).tiles(scan)])


def error_db(got: np.ndarray[Any, Any], exact: np.ndarray[Any, Any]) -> float:
    return float(10 * np.log10(np.sum(np.abs(got - exact) ** 2) / np.sum(np.abs(exact) ** 2)))


@pytest.mark.parametrize("more", [{"scattering": "optics"}, {"material": "wood"}, {"rcs_dbsm": 30}], ids=str)
@pytest.mark.parametrize("sea", [{}, {"sea_state": 4}], ids=["calm", "sea"])
def test_a_body_and_its_shadow_are_there_from_the_first_spoke_after_it_appears(
    more: dict[str, Any], sea: dict[str, Any]
) -> None:
    ship = {"name": "ship", "position_m": [0, 200, 0], **SHIP, **more}
    settings = {"radar": RADAR, "environment": sea}
    appears = 1.0 + 3.5 / 64  # s: between the spokes 67 and 68, where the beam is on ship and wall
    late = whole_scan(scene([WALL, {**ship, "start_s": appears}], **settings), 1)
    with_it, without = (whole_scan(scene([WALL, *ships], **settings), 1) for ships in ([ship], []))
    assert error_db(without[4:], with_it[4:]) > -20.0, "ship and shadow matter"
    if sea:  # rows of the sea have their own instants, about which the beam spreads the change
        late, with_it, without = (np.delete(each, range(8), axis=0) for each in (late, with_it, without))
        before = slice(0, 0)
    else:
        before = slice(0, 4)
        np.testing.assert_array_equal(late[before], without[before])
    after = slice(before.stop, None)
    assert error_db(late[after], with_it[after]) < GRID_DB


def test_a_body_that_never_appears_in_time_is_as_good_as_none() -> None:
    ship = {"name": "ship", "position_m": [0, 200, 0], **SHIP, "scattering": "optics", "start_s": 100.0}
    np.testing.assert_array_equal(whole_scan(scene([WALL, ship], radar=RADAR), 1), whole_scan(scene([WALL], radar=RADAR), 1))


@pytest.mark.parametrize("spread", [False, True])
def test_fading_is_by_scan_and_truth_tells_absent_bodies(spread: bool) -> None:
    fading = {"present": 2, "of": 4, "spread": spread}
    made = scene([point("p", 0, -300, fading=fading), point("q", 0, -450)], radar=RADAR)
    sim = Simulator(made)
    rows, bin_of_p = [], int(300 / made.radar.range_step)
    for scan in range(6):
        field = np.abs(sim.scan().field)
        rows.append(bool(field[:, bin_of_p - 1 : bin_of_p + 2].max() > field.max() / 2.0))
        p, q = sorted(sim.crossings(scan), key=lambda crossing: crossing.body)
        assert (p.visible, p.reason) == (rows[-1], "" if rows[-1] else "absent") and q.visible
        assert sim.truth((scan + 0.5) * 1.0).bodies[0].visible == rows[-1]
    assert rows == ([True, False] * 3 if spread else [True, True, False, False, True, True])


def test_an_end_is_exact_for_each_spoke_and_for_the_documented_fidelity() -> None:
    gone = 0.5 + 0.5 / 64  # s: after spoke 32
    bodies = [point("p", 0, -300, end_s=gone), {**WALL, "position_m": [0, -400, 0], "end_s": gone}]
    made = scene(bodies, radar={**RADAR, "rays": 200})
    sim = whole_scan(made, 0)
    assert np.abs(sim[32]).max() > 0.0 and not np.abs(sim[33:]).any()
    documented = DocumentedEngine(made, fidelity_from_name("documented"), 0)
    assert np.abs(documented.azimuth_field(0, 32)).max() > 0.0 and not np.abs(documented.azimuth_field(0, 33)).any()


def test_rays_meet_no_absent_body() -> None:
    rays = rs.Fidelity(**{**vars(fidelity_from_name("balanced")), "sampler": "stratified"})
    ship = {"name": "ship", "position_m": [0, 200, 0], **SHIP, "material": "wood"}
    made = {start: scene([{**ship, "start_s": start}], radar=RADAR) for start in (0.0, 50.0)}
    assert np.abs(whole_scan(made[0.0], 0, rays)).max() > 0.0 and not np.abs(whole_scan(made[50.0], 0, rays)).any()


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"start_s": 5.0, "end_s": 5.0}, "end_s: 5 is not after start_s 5"),
        ({"start_s": -1.0}, "start_s"),
        ({"fading": {"present": 6, "of": 5}}, "present: 6 units are more than of = 5"),
        ({"fading": {"present": 1, "of": 5, "unit_s": 0.0}}, "unit_s"),
    ],
)
def test_impossible_schedules_are_refused(more: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        scene([point("p", 0, 300, **more)])
