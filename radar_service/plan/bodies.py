"""The bodies of a scene: how each one is modelled, or why not, with its error and its cost."""

import numpy as np

from radar_service.engine.land_rows import is_diffuse_land
from radar_service.engine.preparation import rests
from radar_service.numerics.types import Floats, Indices
from radar_service.plan.body_errors import body_error
from radar_service.plan.statistics import EngineStatistics
from radar_service.records.fidelity import Fidelity
from radar_service.records.plan_item import PlanItem
from radar_service.scattering.models import scattering_model
from radar_service.scattering.predictions import Conditions
from radar_service.world.body import Body
from radar_service.world.scene import Scene

NEVER_VISIBLE = "never visible: other bodies at rest occlude it, or it is out of range"


def bodies(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[PlanItem]:
    """The items of all bodies, in their order."""
    costs = _microseconds(scene, fidelity, statistics)
    return [_body(key, scene, fidelity, statistics, costs[key]) for key in range(len(scene.bodies))]


def _microseconds(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[float | None]:
    """CPU time of each body while the radar turns [us]: moving bodies share that of moving echoes by their echoes, and those
    whose echoes depend on aspect that of their aspects."""
    if statistics.costs is None or statistics.bodies is None:
        return [None] * len(scene.bodies)
    moving = np.array([not rests(body, scene, fidelity) for body in scene.bodies], dtype=np.bool_)
    by_aspect = np.array([scattering_model(body).by_aspect for body in scene.bodies], dtype=np.bool_)
    echoes = np.where(moving, statistics.bodies.echoes, 0)
    shares = (_shared(statistics.costs.moving, echoes), _shared(statistics.costs.aspects, echoes * by_aspect))
    return [float(time) for time in shares[0] + shares[1]]


def _shared(cost: float, count: Indices) -> Floats:
    """A cost shared (B,) by counts (B,)."""
    return np.asarray(count * (cost / max(int(count.sum()), 1)))


def _body(key: int, scene: Scene, fidelity: Fidelity, statistics: EngineStatistics, microseconds: float | None) -> PlanItem:
    body = scene.bodies[key]
    what = f"body {body.name}"
    if fidelity.engine == "documented":
        how = "one hit per azimuth" if body.mesh is None else f"rays against {len(body.mesh.faces)} triangles"
        return PlanItem(what, True, how)
    if key in statistics.culled:
        culled = statistics.culled[key]
        shadow = "; still occludes what is behind it" if culled.occludes else ""
        return PlanItem(what, False, culled.reason + shadow, culled.error_db)
    if statistics.bodies is not None and rests(body, scene, fidelity) and not statistics.bodies.echoes[key]:
        return PlanItem(what, False, NEVER_VISIBLE, 0.0, microseconds=0.0)
    model = scattering_model(body, fidelity.sampler)
    scatterers = None if statistics.bodies is None else int(statistics.bodies.scatterers[key])
    conditions = Conditions.of_scene(scene, fidelity, scatterers)
    how = model.description(body, conditions, _computed(body, scene, fidelity, statistics))
    error = body_error(body, scene, fidelity, scatterers)
    text = "; ".join((how + _counted(body, key, statistics), *error.remarks))
    return PlanItem(what, True, text, error.power_db, error.field_db, microseconds)


def _computed(body: Body, scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> str:
    """How often a body is computed, as text."""
    if rests(body, scene, fidelity):
        return "computed once"
    on_grid = statistics.land_border is not None and is_diffuse_land(body, fidelity)
    return "computed once a passage" if on_grid else "computed at each azimuth"


def _counted(body: Body, key: int, statistics: EngineStatistics) -> str:
    """Scatterers and echoes of a body as text, once they are known."""
    if statistics.bodies is None:
        return ""
    scatterers, echoes = int(statistics.bodies.scatterers[key]), int(statistics.bodies.echoes[key])
    if scatterers == 1:
        size = "a point" if body.mesh is None else "smaller than a resolution cell: a point"
        return f"; {size}" if echoes else f"; {size}, not visible now"
    return f"; {scatterers} points, {echoes} echoes" if scatterers else f"; {echoes} echoes"
