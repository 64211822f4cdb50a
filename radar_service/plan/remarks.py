"""What `check` says of each body over the run: its closest approach, and errors that grow towards it."""

import math

from radar_service.plan.body_errors import body_error
from radar_service.plan.run import HORIZON, BodyRun, body_run, ends_at_horizon, is_steered
from radar_service.records.fidelity import Fidelity
from radar_service.scattering.physical_optics.mesh_quality import mesh_quality
from radar_service.world.body import Body
from radar_service.world.scene import Scene


def body_remarks(scene: Scene, fidelity: Fidelity) -> dict[str, list[str]]:
    """Sentences about each body, by its name."""
    runs = {body.name: body_run(body, scene) for body in scene.bodies}
    quality = mesh_quality(scene, fidelity.bounces, {name: run.nearest for name, run in runs.items()})
    return {
        body.name: [
            *_passage(body, scene, runs[body.name]),
            *quality.get(body.name, []),
            *(body_error(body, scene, fidelity, None).remarks if body.name not in quality else ()),
        ]
        for body in scene.bodies
    }


def _passage(body: Body, scene: Scene, run: BodyRun) -> list[str]:
    """When a body is nearest, and how fast its aspect changes; nothing where it stays."""
    if scene.own_ship.at_rest and body.motion.at_rest:
        return []
    if is_steered(body, scene):
        return [
            "commands may bring it anywhere: errors are bounds for the antenna beside it, at the limits of speed and turn: "
            f"its aspect turns by up to {math.degrees(run.turn):.2g} degrees/s, its range by {run.radial:.2g} m/s"
        ]
    when = "now" if run.time == 0.0 else f"after {run.time:.0f} s"
    loops = f"; its loops are followed for {HORIZON:.0f} s" if ends_at_horizon(body, scene) else ""
    turn = f"its aspect turns by up to {math.degrees(run.turn):.2g} degrees/s, its range by {run.radial:.2g} m/s"
    return [f"nearest {when}: {run.nearest:.0f} m; {turn}{loops}"]
