"""The bodies of a scene: what each one needs, what it needs not, and what it errs and costs."""

import math

import numpy as np

from radar_service.fidelity import Fidelity
from radar_service.plan.effects import missed
from radar_service.plan.items import PlanItem
from radar_service.plan.settings_search import density_db, surface_db
from radar_service.plan.statistics import EngineStatistics
from radar_service.scattering.physical_optics.facets import MOST
from radar_service.scattering.physical_optics.optical_body import coarsening
from radar_service.scattering.physical_optics.patches import faces_something
from radar_service.scene.world import Body, Mesh, Scene

SAMPLER_WORDS = {"rays": "uniform random", "stratified": "stratified", "sobol": "Sobol'"}
FACETS_DB, BOUNCES_DB = 0.1, 0.4  # single surfaces and corners against their formulas (tests/echo/optics)


def bodies(scene: Scene, fidelity: Fidelity, record: EngineStatistics) -> list[PlanItem]:
    """The choices for all bodies, in their order."""
    prices = _microseconds(scene, record)
    return [_body(key, scene, fidelity, record, prices[key]) for key in range(len(scene.bodies))]


def _microseconds(scene: Scene, record: EngineStatistics) -> list[float | None]:
    """What each body costs while the radar turns [us]: what is laid anew for every azimuth shares that by its echoes."""
    if record.costs is None or record.bodies is None:
        return [None] * len(scene.bodies)
    moving = np.array([not _rests(body, scene) for body in scene.bodies], dtype=np.bool_)
    echoes = np.where(moving, record.bodies.echoes, 0)
    each = record.costs.moving / max(int(echoes.sum()), 1)
    return [float(count * each) for count in echoes]


def _body(key: int, scene: Scene, fidelity: Fidelity, record: EngineStatistics, microseconds: float | None) -> PlanItem:
    body = scene.bodies[key]
    what = f"body {body.name}"
    if fidelity.chain == "documented":
        how = "one hit per azimuth" if body.mesh is None else f"rays against {len(body.mesh.faces)} triangles"
        return PlanItem(what, True, how)
    if key in record.culled:
        gone = record.culled[key]
        return PlanItem(what, False, gone.reason + ("; still hides what is behind it" if gone.hides else ""), gone.error_db)
    if record.bodies is not None and _rests(body, scene) and not record.bodies.echoes[key]:
        return PlanItem(
            what, False, "shadowed for good: nothing of it is seen past what rests, or heard", 0.0, microseconds=0.0
        )
    how, error = _scattering(body, scene, fidelity)
    if record.bodies is not None and record.bodies.scatterers[key] > 1:
        error = _surface_error(body, int(record.bodies.scatterers[key]), scene, error)
    return PlanItem(what, True, how + _counted(body, key, record), error, microseconds=microseconds)


def _surface_error(body: Body, points: int, scene: Scene, of_patches: float | None) -> float | None:
    """Error of the mean power [dB] of a surface on so many points, where that is more than that of its patches. A declared
    cross-section is kept exactly but for the lobes of the sea's mirror that it stands in."""
    if body.rcs is not None and not scene.environment.multipath:
        return 0.0
    return max(of_patches or 0.0, surface_db(points, scene.environment.multipath))


def _scattering(body: Body, scene: Scene, fidelity: Fidelity) -> tuple[str, float | None]:
    """How a body scatters, and by how much its mean power errs [dB]."""
    gridded = "laid once" if _rests(body, scene) else "laid azimuth by azimuth"
    if body.rcs is not None:
        kind = f"declared cross-section, Swerling {body.swerling}" if body.swerling else "declared cross-section, steady"
        return f"{kind}, {gridded}", 0.0
    if body.scattering == "optics" and body.mesh is not None:
        return _optics(body, body.mesh, scene, fidelity, gridded)
    if fidelity.sampler != "scatterers":
        rays = f"{SAMPLER_WORDS[fidelity.sampler]} rays, {scene.radar.rays} to 3 x 3 beamwidths ({missed(scene)})"
        return f"diffuse, {gridded}, by {rays}; beyond 1.5 beamwidths above and below nothing is met", None
    per_cell = fidelity.scatterers_per_cell
    return f"diffuse, {gridded}, {per_cell:g} scatterers to a resolution cell", density_db(per_cell)


def _optics(body: Body, mesh: Mesh, scene: Scene, fidelity: Fidelity, gridded: str) -> tuple[str, float]:
    distance = math.dist(body.middle_at(0.0), scene.antenna(0.0)[0]) - body.radius
    times = coarsening(body, scene.radar, distance)
    coarse = "" if times == 1.0 else f"; pieces {times:.1f} times longer than they should be, at most {MOST} of them"
    if not faces_something(mesh).any():
        return (
            f"physical optics, {len(mesh.faces)} facets, none of which faces another: no bounces, {gridded}{coarse}",
            FACETS_DB,
        )
    return f"physical optics, up to {fidelity.bounces} bounces, {gridded}{coarse}", BOUNCES_DB


def _counted(body: Body, key: int, record: EngineStatistics) -> str:
    """Points and echoes of a body, once they are known."""
    if record.bodies is None:
        return ""
    points, echoes = int(record.bodies.scatterers[key]), int(record.bodies.echoes[key])
    if points == 1:
        size = "a point" if body.mesh is None else "smaller than a resolution cell: a point"
        return f"; {size}" if echoes else f"; {size}, not in sight now"
    return f"; {points} points, {echoes} echoes" if points else f"; {echoes} echoes"


def _rests(body: Body, scene: Scene) -> bool:
    return scene.own_ship.at_rest and body.motion.at_rest and body.swerling == 0
