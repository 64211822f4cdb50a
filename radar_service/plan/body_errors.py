"""Errors of a body over a whole run, predicted at its closest approach, and what `check` says of it: when that is, and why."""

import math
from typing import NamedTuple

import numpy as np

from radar_service.echo.closest_approach import nearest_and_top
from radar_service.echo.passage_nodes import HELD_PHASE, MAX_PHASE
from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.plan.run import HORIZON, body_run, ends_at_horizon, is_steered
from radar_service.plan.settings_search import combine_db
from radar_service.propagation.multipath import specular_geometry
from radar_service.records.fidelity import Fidelity
from radar_service.scattering.models import scattering_model
from radar_service.scattering.predictions import NEAREST, BodyRun, Conditions
from radar_service.world.body import Body
from radar_service.world.scene import Scene

NODES = 0.1  # of MAX_PHASE squared: the field between nodes so far apart, measured (tests/plan/test_body_errors.py)
HELD = 0.2  # of the field, at HELD_PHASE: that of one node, by its square; 95 % of 73 passing plates err less
ASPECT_FLOOR_DB = -65.0  # centres that are left out, at other moments others
EXCESS_SHARE = 0.1  # of the range cell: a longer way by the sea moves a part of a point's echo by so much


class BodyError(NamedTuple):
    """Errors of a body over a run, None where they do not apply.

    power_db: of its mean power [dB].
    field_db: of its field, relative [dB].
    remarks: sentences about them.
    """

    power_db: float | None
    field_db: float | None
    remarks: tuple[str, ...]


def body_error(body: Body, scene: Scene, fidelity: Fidelity, scatterers: int | None) -> BodyError:
    """What is predicted for a body over its run; scatterers: how many it has, None before they are drawn."""
    model, conditions = scattering_model(body, fidelity.sampler), Conditions.of_scene(scene, fidelity, scatterers)
    power = model.error_db(body, conditions)
    remarks = _split_paths(body, scene) if model.tells_sea_delay and scene.environment.multipath else []
    if body.mesh is None or power is None:
        return BodyError(power, None, tuple(remarks))
    run = body_run(body, scene)
    over_run, aspects = model.run_error(body, conditions, run), aspect_db(body, scene, run)
    field = aspects if math.isfinite(aspects) else None
    return BodyError(math.hypot(power, over_run.power_db), field, (*over_run.remarks, *remarks))


def aspects_db(scene: Scene) -> float:
    """Predicted relative field error [dB] of interpolating echoes between aspects: the worst of all bodies at any time of the
    run; -inf where no aspect changes, or no echo depends on it."""
    bodies = [body for body in scene.bodies if scattering_model(body).by_aspect]
    return max((aspect_db(body, scene, body_run(body, scene)) for body in bodies), default=-math.inf)


def aspect_db(body: Body, scene: Scene, run: BodyRun) -> float:
    """The error of `aspects_db` of one body: of second order in the phase that its echoes turn while the main beam passes."""
    radar = scene.radar
    rate = run.turn + (run.sea_turn if scene.environment.multipath else 0.0)
    size = min(scattering_model(body).coherence_at(body, radar, max(run.nearest, NEAREST)), body.diagonal)
    turned = 2.0 * np.pi / radar.wavelength * size * rate * radar.rotation_period * radar.beamwidth / (2.0 * np.pi)
    if turned == 0.0:
        return -math.inf
    error = min(HELD * (turned / HELD_PHASE) ** 2, NODES * MAX_PHASE**2)
    return combine_db(20.0 * math.log10(error), ASPECT_FLOOR_DB)


def _split_paths(body: Body, scene: Scene) -> list[str]:
    """Where the way by the sea is so much longer that it should be an echo of its own; not of land."""
    nearest, top = nearest_and_top(body, scene)
    if not 0.0 < top < math.inf or _excess_cells(nearest, top, scene) <= EXCESS_SHARE:
        return []
    nearest = body_run(body, scene).nearest
    cells = _excess_cells(nearest, top, scene)
    if cells <= EXCESS_SHARE or body.radius > nearest:
        return []
    return [f"at its closest the way by the sea is {cells:.2g} range cells longer; the echo keeps the direct range"]


def _excess_cells(distance: float, top: float, scene: Scene) -> float:
    """How many range cells longer the way by the sea is, to a height `top` [m] at `distance` [m]."""
    radar = scene.radar
    cell = SPEED_OF_LIGHT * radar.pulse / 2.0 if radar.modulation == "none" else radar.range_resolution
    return float(specular_geometry(max(distance, NEAREST), top, radar.height).excess) / cell


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
