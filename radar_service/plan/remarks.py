"""What `check` says of each body over the run: its closest approach, and errors that grow towards it."""

import math

from radar_service.plan.body_errors import body_error
from radar_service.plan.run import HORIZON, body_run, ends_at_horizon, is_steered
from radar_service.records.fidelity import Fidelity
from radar_service.scattering.models import scattering_model
from radar_service.scattering.predictions import BodyRun, Conditions
from radar_service.world.body import Body
from radar_service.world.scene import Scene


def body_remarks(scene: Scene, fidelity: Fidelity) -> dict[str, list[str]]:
    """Sentences about each body, by its name."""
    return {body.name: _remarks(body, scene, fidelity) for body in scene.bodies}


def _remarks(body: Body, scene: Scene, fidelity: Fidelity) -> list[str]:
    """What a model says of the mesh of a body takes the place of remarks about its errors."""
    run, model = body_run(body, scene), scattering_model(body, fidelity.sampler)
    mesh = model.mesh_remarks(body, Conditions.of_scene(scene, fidelity), run.nearest)
    return [*_passage(body, scene, run), *(mesh or body_error(body, scene, fidelity, None).remarks)]


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
