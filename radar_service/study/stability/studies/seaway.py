"""Ships in a seaway: rising waves, in which metal moves ever faster between the instants at which it is evaluated."""

from dataclasses import fields, replace

import numpy as np

from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics import Floats, Profiles
from radar_service.records import PRESETS
from radar_service.study.stability.finding import (
    Axis,
    Expected,
    Finding,
    crossing,
    curve,
    decades,
    error_db,
    plain,
    scene_of,
)
from radar_service.world import Body, Mesh, Motion, Path, Scene, SeawayMotion

LIMIT_DB = -40.0  # of the field: the default error budget
PERIOD = 5.0  # s of the waves' peak
BOAT = {
    "shape": "hull", "length_m": 12.0, "beam_m": 4.0, "height_m": 4.0, "position_m": [0.0, 300.0, -1.0], "heading_deg": 40.0,
    "scattering": "optics", "material": "steel",
}  # fmt: skip
RADAR = {"azimuths": 720, "beamwidth_deg": 6.0, "rpm": 24}
SPOKES = (-4, 0, 4)  # of the main beam, about the second crossing


class UnheededMotion(SeawayMotion):
    """The same motion, whose rates the choice of nodes does not see."""

    def rates_about(self, time: Floats, path: Path) -> Floats:
        """Returns 0."""
        return np.zeros((1, 4))


def ships_in_waves(fine: int = 1) -> Finding:
    """Drives the height of waves under a steel boat: spokes of a passage against the boat at rest in the pose of each spoke."""
    heights = decades(0.03, 3.0, fine)
    scenes = [_boat_in(height) for height in heights]
    engine = [_passage_error(scene) for scene in scenes]
    single = [_passage_error(_unheeded(scene)) for scene in scenes]
    return Finding(
        name="ships in a seaway",
        method="one aspect a passage",
        setup=f"a steel boat of 12 m, 300 m away, in waves of {PERIOD:g} s",
        parameter=Axis("significant wave height [m]", log=True),
        values=plain(heights),
        measured=Axis("field error [dB]"),
        curves=(curve("aspects as rates ask", engine), curve("one aspect a passage", single)),
        limit=LIMIT_DB,
        limit_reason="the default error budget",
        boundary=crossing(heights, np.array(single), LIMIT_DB, log=True),
        expected=Expected(0.17, 0.25, "measured: 0.155 m and, with more heights, 0.145 to 0.185"),
        response="another method",
        instead="aspects as close as roll, pitch and heave ask",
        details="Between two instants at which metal is evaluated, roll turns its facets and heave moves its waterline. "
        "Instants are as close as these rates ask. "
        "Motions are linear at any height: waves above 5 m in 5 s cannot exist.",
    )


def _boat_in(height: float) -> Scene:
    sea = {"height_m": float(height), "period_s": PERIOD, "from_deg": 280.0}
    return scene_of(BOAT, radar=RADAR, environment={"multipath": True, "seaway": sea}, own_ship={"hull": {"floats": False}})


def _with_motion(scene: Scene, motion: Motion, mesh: Mesh | None = None) -> Scene:
    (body,) = scene.bodies
    return scene.with_world(bodies=(replace(body, motion=motion, mesh=body.mesh if mesh is None else mesh),))


def _unheeded(scene: Scene) -> Scene:
    """The scene with a boat that reports no rates of roll, pitch and heave, so that nodes are chosen without them."""
    motion = scene.bodies[0].motion
    assert isinstance(motion.sway, SeawayMotion)
    sway = UnheededMotion(**{field.name: getattr(motion.sway, field.name) for field in fields(SeawayMotion)})
    return _with_motion(scene, replace(motion, sway=sway))


def _frozen(scene: Scene, time: float) -> Scene:
    """The scene at rest, as it is at a time [s]: the mesh leans."""
    (body,) = scene.bodies
    pose, mesh = body.motion.pose(time), body.mesh
    assert pose.rotation is not None and mesh is not None
    upright = Motion(np.zeros(1), pose.position, pose.heading)
    lean = upright_rotation(body, time)
    return _with_motion(scene, upright, Mesh(mesh.vertices @ lean.T, mesh.faces))


def upright_rotation(body: Body, time: float) -> Floats:
    """Returns the rotation (3, 3) from a body's frame to that of the upright body at a time [s]."""
    rotation: Floats = body.motion.sway_state(np.array([time])).rotation(np.zeros(1))[0]
    return rotation


def _passage_error(scene: Scene) -> float:
    """Returns the field error [dB] of spokes of the main beam."""
    prepared, got, exact = _prepared(scene), [], []
    for spoke in scene.radar.azimuths + np.array(SPOKES):
        got.append(_field(prepared, int(spoke)))
        exact.append(_field(_prepared(_frozen(scene, spoke * scene.radar.spoke_period)), int(spoke)))
    return error_db(np.array(got), np.array(exact))


def _prepared(scene: Scene) -> Prepared:
    return prepare(scene, PRESETS["balanced"], 0)


def _field(prepared: Prepared, spoke: int) -> Profiles:
    """Returns the profile (N,) of one spoke, numbered from the start."""
    scan, index = divmod(spoke, prepared.scene.radar.azimuths)
    start = index // prepared.tile * prepared.tile
    field: Profiles = profiles(prepared, tile_azimuths(prepared, scan, start))[index - start]
    return field


STUDIES = (ships_in_waves,)
