"""Bodies that roll, pitch, yaw and heave, against scenes at rest in the pose of one instant, and against closed forms."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.documented import DocumentedEngine
from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.frames import effective_earth_radius
from radar_service.records.fidelity import fidelity_from_name
from radar_service.scattering.rays import RayCaster
from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
from radar_service.world.body import Mesh
from radar_service.world.motion import Motion
from tests.scenes import point, scene

Floats = NDArray[np.float64]
RADAR = {"range_max_m": 600, "azimuths": 64, "beamwidth_deg": 12, "pulse_s": 1e-6, "rpm": 60, "height_m": 12}
SWAY = {"roll_deg": 20.0, "roll_period_s": 6.0, "roll_phase_deg": 40.0, "pitch_deg": 8.0, "pitch_period_s": 5.0,
        "pitch_phase_deg": 200.0, "yaw_deg": 10.0, "yaw_period_s": 7.0, "heave_m": 0.8, "heave_period_s": 4.0,
        "heave_phase_deg": 100.0}  # fmt: skip
BALANCED = fidelity_from_name("balanced")
REST_DB = -45.0  # what rests goes over the grid, -60 dB of its peak, a fifth of which a spoke may be (docs/engine.md#errors)
EARTH = 4.0 / 3.0 * 6_371_000.0
SCENES = Path(__file__).parents[1] / "scenes"

METAL: dict[str, dict[str, Any]] = {
    "plate": {"shape": "plate", "width_m": 3.0, "height_m": 2.0, "position_m": [0, 300, 6], "heading_deg": 178.0},
    "plate in the water": {"shape": "plate", "width_m": 3, "height_m": 4, "position_m": [0, 300, -1], "heading_deg": 178.0},
    "corner": {"shape": "trihedral", "edge_m": 1.0, "position_m": [0, 300, 6], "heading_deg": 178.0},
    "turning hull": {"shape": "hull", "length_m": 24.0, "beam_m": 6.0, "height_m": 6.0, "position_m": [0, 300, -1],
                     "course_deg": 80.0, "speed_kn": 8.0, "turn_rate_deg_s": 3.0},
}  # fmt: skip


def wave(keys: dict[str, Any], name: str, unit: str, period: float, time: float) -> float:
    """One angle [degrees] or the heave [m] as docs/scenes.md defines it."""
    phase = np.deg2rad(keys.get(f"{name}_phase_deg", 0.0))
    return float(keys.get(f"{name}_{unit}", 0.0) * np.sin(2 * np.pi * time / keys.get(f"{name}_period_s", period) + phase))


def lean(keys: dict[str, Any], time: float) -> Floats:
    """Roll with the starboard side (x) down, then pitch with the bow (y) up."""
    r, p = (np.deg2rad(wave(keys, name, "deg", period, time)) for name, period in (("roll", 10.0), ("pitch", 7.0)))
    roll = np.array([[np.cos(r), 0, np.sin(r)], [0, 1, 0], [-np.sin(r), 0, np.cos(r)]])
    pitch = np.array([[1, 0, 0], [0, np.cos(p), -np.sin(p)], [0, np.sin(p), np.cos(p)]])
    return np.asarray(pitch @ roll)


def frozen(made: rs.Scene, keys: list[dict[str, Any]], time: float) -> rs.Scene:
    """The scene at rest as it is at `time`: meshes lean, heights have the heave."""
    bodies = []
    for body, motion in zip(made.bodies, keys, strict=True):
        upright = replace(body.motion, sway=None).pose(time)
        mesh = None if body.mesh is None else Mesh(body.mesh.vertices @ lean(motion, time).T, body.mesh.faces)
        position = upright.position + np.array([[0.0, 0.0, wave(motion, "heave", "m", 8.0, time)]])
        heading = upright.heading + np.deg2rad(wave(motion, "yaw", "deg", 20.0, time))
        bodies.append(replace(body, mesh=mesh, motion=Motion(np.zeros(1), position, heading)))
    return made.with_world(bodies=tuple(bodies))


def spoke(prepared: Prepared, number: int) -> NDArray[np.complex64]:
    """The field of one spoke, numbered from the start."""
    scan, index = divmod(number, prepared.scene.radar.azimuths)
    start = index // prepared.tile * prepared.tile
    field: NDArray[np.complex64] = profiles(prepared, tile_azimuths(prepared, scan, start))[index - start]
    return field


def error_db(got: NDArray[np.complex64], exact: NDArray[np.complex64]) -> float:
    return float(20 * np.log10(np.linalg.norm(got - exact) / np.linalg.norm(exact)))


def frozen_errors(
    bodies: list[dict[str, Any]], numbers: list[int], fidelity: rs.Fidelity = BALANCED, **sections: Any
) -> list[float]:
    """Errors [dB] of spokes against the scene at rest as it is then, relative to the strongest of them."""
    made = scene(bodies, radar=RADAR, **sections)
    engine = prepare(made, fidelity, 3)
    stills = [frozen(made, bodies, number * made.radar.spoke_period) for number in numbers]
    exact = np.array([spoke(prepare(still, fidelity, 3), number) for still, number in zip(stills, numbers, strict=True)])
    got = np.array([spoke(engine, number) for number in numbers])
    errors = np.linalg.norm(got - exact, axis=1) / np.linalg.norm(exact, axis=1).max()
    return [float(20 * np.log10(error)) for error in errors]


LATE = 64 * 3600  # spokes: an hour
EVERY_WAY = pytest.mark.parametrize("multipath", [False, True])


@EVERY_WAY
@pytest.mark.parametrize("start", [0, LATE])
def test_a_swaying_point_is_where_it_is_in_each_frozen_instant(multipath: bool, start: int) -> None:
    bodies = [point("p", 100, 300, 5, **SWAY)]
    errors = frozen_errors(bodies, [start + k for k in (2, 3, 4, 66, 131)], environment={"multipath": multipath})
    assert max(errors) < REST_DB, errors


@pytest.mark.sample(3)
@EVERY_WAY
@pytest.mark.parametrize("name", METAL)
def test_swaying_metal_is_the_metal_of_each_frozen_instant(name: str, multipath: bool) -> None:
    """With waterline and reflection, at the nodes at which it is evaluated; of the corner all bounces, of others the first."""
    fidelity = BALANCED if name == "corner" else replace(BALANCED, bounces=1)
    bodies = [{"name": "b", "scattering": "optics", **METAL[name], **SWAY}]
    made = scene(bodies, radar=RADAR, environment={"multipath": multipath})
    passages = prepare(made, fidelity, 3).moving.passages
    crossings = [passages.crossing(0, scan) for scan in (1, 40)]
    nodes = [n for crossing in crossings for n in passages.nodes(0, crossing).tolist() if abs(n - crossing) < 2]
    assert nodes
    errors = frozen_errors(bodies, nodes, fidelity, environment={"multipath": multipath})
    assert max(errors) < REST_DB, errors


@pytest.mark.parametrize(
    ("mesh", "course", "distance", "roll"),
    [
        ("coaster.obj", 342.0, 200.0, 0.0), pytest.param("ferry.obj", 298.0, 545.0, -6.3, marks=pytest.mark.study),
        *(pytest.param(mesh, course, 545.0, roll, marks=pytest.mark.study)
          for mesh in ("coaster.obj", "ferry.obj", "freighter.obj", "tanker.obj") for course in (0, 40, 90, 152, 271)
          for roll in (0.0, 1.0, -6.3)),
    ],
)  # fmt: skip
def test_rounding_decides_nothing_of_a_ship(mesh: str, course: float, distance: float, roll: float) -> None:
    """A ship that rolls by 1e-9 degrees more has the same field: what is cut, and what reflects onto what, hangs on no last
    bit. 1e-9 degrees move it by 1 nm, 1e-7 of a radian."""
    keys = {"course_deg": course, "speed_kn": 1.0, "roll_period_s": 10.0, "roll_phase_deg": -90.0 if roll < 0.0 else 90.0}
    body = {"name": "ship", "mesh": mesh, "scattering": "optics", "position_m": [0, distance, 0], **keys}
    fields = []
    for angle in (abs(roll) or 1e-12, abs(roll) + 1e-9):
        table = {
            "radar": {**RADAR, "range_max_m": 900},
            "environment": {"multipath": True},
            "body": [body | {"roll_deg": angle}],
        }
        engine = prepare(rs.load_scene(table, folder=SCENES), BALANCED, 3)
        fields.append(spoke(engine, 0))
    assert error_db(fields[1], fields[0]) < -60.0


def test_own_ships_heave_lifts_the_antenna_and_its_reflection() -> None:
    keys = {"heave_m": 0.7, "heave_period_s": 5.0, "heave_phase_deg": 30.0}
    bodies, numbers = [point("p", 100, 300, 5)], [3, 67, 64 * 100 + 3]
    made = scene(bodies, radar=RADAR, own_ship=keys, environment={"multipath": True})
    engine = prepare(made, BALANCED, 3)
    for number in numbers:
        lift = wave(keys, "heave", "m", 8.0, number * made.radar.spoke_period)
        assert made.antenna(number * made.radar.spoke_period)[0, 2] == pytest.approx(12 + lift, abs=1e-9)
        still = scene(bodies, radar={**RADAR, "height_m": 12 + lift}, environment={"multipath": True})
        assert error_db(spoke(engine, number), spoke(prepare(still, BALANCED, 3), number)) < REST_DB
    without = scene(bodies, radar=RADAR, environment={"multipath": True})
    assert error_db(spoke(prepare(without, BALANCED, 3), 67), spoke(engine, 67)) > -10.0, "the heave matters"


@pytest.mark.parametrize("time", [0.0, 1.1, 77.7])
def test_a_swaying_hull_shadows_what_its_frozen_instant_shadows(time: float) -> None:
    hull = {"name": "b", **METAL["turning hull"], "material": "wood", **SWAY}
    made = scene([hull, point("far", 0, 500)], radar=RADAR)
    rng, earth = np.random.default_rng(5), effective_earth_radius(made.environment.earth_factor)
    spots = np.column_stack([rng.uniform(-30, 30, 4000), rng.uniform(310, 560, 4000), rng.uniform(0, 15, 4000)])
    spots[:, :2] += made.bodies[0].motion.pose(time).position[0, :2] - [0, 300]
    points, antenna = SurfacePoints(np.ones(4000, dtype=np.int64), np.full(4000, -1), spots), np.array([0.0, 0.0, 12.0])
    still = frozen(made, [hull, {}], time)
    swaying, resting, upright = (
        OcclusionScene(each.bodies, earth).visible(points, antenna, time, 1e4)
        for each in (made, still, frozen(made, [{}, {}], time))
    )
    assert np.count_nonzero(swaying != resting) <= 2, "rays within 2 mm of an edge"
    assert np.count_nonzero(swaying != upright) > 4 * np.count_nonzero(swaying != resting)


def test_a_diffuse_hull_keeps_its_scatterers_where_its_rotation_puts_them() -> None:
    """Echoes of the visibility step, carried to each azimuth by the rotation written out here."""
    hull = {"name": "b", **METAL["turning hull"], "material": "wood", **SWAY}
    made = scene([hull], radar=RADAR)
    engine = prepare(made, BALANCED, 3)
    scan, start = 5, 0
    azimuths = tile_azimuths(engine, scan, start)
    got = engine.moving.echoes(azimuths)
    step = int(azimuths.middle // engine.moving.visibility.interval)
    snapshot = engine.moving.snapshot(step, azimuths.middle)
    assert len(snapshot.echoes) > 5
    middle = (azimuths.time[0] + azimuths.time[-1]) / 2
    still = frozen(made, [hull], middle).bodies[0]
    heading = still.motion.pose(0.0).heading[0]
    c, s = np.cos(heading), np.sin(heading)
    spots = snapshot.echoes.position @ lean(hull, middle).T @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    offset = spots + still.motion.position[0] - np.array([0.0, 0.0, 12.0])
    ground2 = offset[:, 0] ** 2 + offset[:, 1] ** 2
    ranges = np.sqrt(ground2 + (offset[:, 2] - ground2 / (2 * EARTH)) ** 2)
    assert len(got.range) > 5
    distance = np.abs(got.range[:, None] - ranges).min(axis=1)
    assert distance.max() < 1e-6  # m, float64


def test_the_truth_of_a_swaying_hull_moves_as_its_positions_do() -> None:
    hull = {"name": "b", **METAL["turning hull"], "material": "wood", **SWAY}
    sim = rs.Simulator(scene([hull], radar=RADAR))
    reference = sim.scene.bodies[0].reference
    crossings = [crossing for _ in range(3) for crossing in (sim.scan(), sim.crossings())[1]]
    assert len(crossings) > 1
    for crossing in crossings:
        body = sim.scene.bodies[0]
        still = frozen(sim.scene, [hull], crossing.time).bodies[0]
        heading = still.motion.pose(0.0).heading[0]
        assert crossing.heading == pytest.approx(heading, abs=1e-12)
        turned = lean(hull, crossing.time) @ reference
        c, s = np.cos(heading), np.sin(heading)
        expected = still.motion.position[0] + [c * turned[0] + s * turned[1], c * turned[1] - s * turned[0], turned[2]]
        np.testing.assert_allclose(crossing.position, expected, atol=1e-9)
        h = 1e-4
        ends = []
        for time in (crossing.time - h, crossing.time + h):
            pose = body.motion.pose(time)
            assert pose.rotation is not None
            ends.append(pose.position[0] + pose.rotation[0] @ reference)
        np.testing.assert_allclose(crossing.velocity, (ends[1] - ends[0]) / (2 * h), atol=1e-6)


@pytest.mark.parametrize("sampler", ["stratified", "documented"])
def test_rays_meet_the_body_as_it_leans(sampler: str) -> None:
    """A plate across the beam, by the ray sampler and by the specification's engine: as at rest in the same pose, to the rays'
    own draws, which do not depend on the body."""
    keys = {"roll_deg": 40.0, "roll_period_s": 6.0, "roll_phase_deg": 60.0}
    size = {"position_m": [0, 300, 30], "material": "wood", "width_m": 90.0, "height_m": 50.0}
    bodies = [{"name": "b", **METAL["plate"], **size, **keys}]
    made = scene(bodies, radar={**RADAR, "rays": 2000})
    still = frozen(made, bodies, 0.0)
    fields = []
    for each in (made, still, frozen(made, [{}], 0.0)):
        if sampler == "documented":
            fields.append(DocumentedEngine(each, fidelity_from_name("documented"), 3).azimuth_field(0, 0))
            continue
        caster = RayCaster(each.bodies, each.radar, EARTH, "stratified", 3)
        hits = caster.hits(each.antenna(0.0)[0], 0.0, 1e3)
        fields.append(np.sort(hits.range))
    got, exact, upright = fields
    assert got.shape == exact.shape
    np.testing.assert_allclose(got, exact, rtol=1e-5, atol=1e-6 * np.abs(exact).max())
    assert upright.shape != got.shape or not np.allclose(upright, got, rtol=1e-3)


@pytest.mark.sample(2)
@pytest.mark.parametrize("scan", [1, 2, 3])
def test_a_heaving_hull_has_its_waterline_at_the_sea_at_every_spoke_of_the_main_beam(scan: int) -> None:
    """The waterline does not rise with the hull: aspects are close enough for that, also where it rests for a moment."""
    hull = {**METAL["turning hull"], "turn_rate_deg_s": 0.0}
    bodies = [{"name": "b", "scattering": "optics", **hull, "heave_m": 0.8, "heave_period_s": 4.0}]
    made = scene(bodies, radar=RADAR)
    crossing = prepare(made, BALANCED, 3).moving.passages.crossing(0, scan)
    errors = frozen_errors(bodies, [crossing - 2, crossing - 1, crossing, crossing + 1, crossing + 2])
    assert max(errors) < REST_DB, errors


@pytest.mark.parametrize(("scan", "error_db"), [(1, -60.0), (2, -20.0)], ids=["one aspect", "another"])
def test_a_heaving_hull_keeps_its_waterline_at_the_sea_between_nodes(
    monkeypatch: pytest.MonkeyPatch, scan: int, error_db: float
) -> None:
    """Spokes so dense that none of these is a node, at two aspects."""
    monkeypatch.setitem(RADAR, "azimuths", 512)
    hull = {**METAL["turning hull"], "turn_rate_deg_s": 0.0}
    bodies = [{"name": "b", "scattering": "optics", **hull, "heave_m": 0.8, "heave_period_s": 4.0}]
    passages = prepare(scene(bodies, radar=RADAR), BALANCED, 3).moving.passages
    crossing = passages.crossing(0, scan)
    spokes = [crossing - 3, crossing + 1, crossing + 2]
    assert not set(spokes) & set(passages.nodes(0, crossing).tolist())
    errors = frozen_errors(bodies, spokes)
    assert max(errors) < error_db, errors


def test_a_plain_hull_that_rolls_and_turns_is_that_of_each_frozen_instant_in_a_faint_aspect(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """20 degrees off its beam facets nearly cancel. What its house reflects grazes the deck, so a tenth of a degree moves its
    foot by metres: shared traces erred by -23 and +0.9 dB. Each scene at rest is traced by itself and has no nodes between it."""
    radar = {"azimuths": 720, "beamwidth_deg": 1.9, "rpm": 24, "bandwidth_hz": 20e6, "height_m": 15, "range_max_m": 900}
    for key, value in radar.items():
        monkeypatch.setitem(RADAR, key, value)
    monkeypatch.delitem(RADAR, "pulse_s")
    crossing, turning, bearing = 684, 3.0, np.deg2rad(342.0)
    start = 52.0 - turning * crossing / 720 * 2.5
    hull = METAL["turning hull"] | {"course_deg": start, "turn_rate_deg_s": turning, "speed_kn": 0.01,
                                    "position_m": [531.5 * np.sin(bearing), 531.5 * np.cos(bearing), -1.0]}  # fmt: skip
    roll = {"roll_deg": 5.0, "roll_period_s": 8.0, "roll_phase_deg": -33.0}
    bodies = [{"name": "b", "scattering": "optics", **hull, **roll}]
    errors = frozen_errors(bodies, [crossing, crossing + 3], fidelity_from_name("balanced"), environment={"multipath": True})
    assert max(errors) < -40.0, errors
