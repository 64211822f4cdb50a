"""Errors of a body over a whole run, each with what it comes from: they are predicted at its closest approach."""

import math
from typing import NamedTuple

import numpy as np

from radar_service.echo.aspect_rates import NEAREST
from radar_service.echo.passage_nodes import HELD_PHASE, MAX_PHASE
from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.plan.closest_approach import nearest_and_top
from radar_service.plan.run import BodyRun, body_run
from radar_service.plan.settings_search import combine_db
from radar_service.propagation.multipath import specular_geometry
from radar_service.records.fidelity import Fidelity
from radar_service.scattering.declared_cells import cell_spacing
from radar_service.scattering.declared_scattering import DeclaredScattering
from radar_service.scattering.fixed_scatterers import DiffuseScattering, FixedScatterers
from radar_service.scattering.models import scattering_model
from radar_service.scattering.physical_optics.mesh_quality import CURVES_DB, MAX_SAG, curve_sag, length_text
from radar_service.scattering.physical_optics.model import FACETS_DB, PhysicalOptics
from radar_service.scattering.physical_optics.optical_body import edge_limits, facet_enlargement
from radar_service.scattering.surface_sampling import density_db
from radar_service.world.body import Body
from radar_service.world.scene import Scene

NODES = 0.1  # of MAX_PHASE squared: the field between nodes so far apart, measured (tests/plan/test_body_errors.py)
HELD = 0.2  # of the field, at HELD_PHASE: that of one node, by its square; 95 % of 73 passing plates err less
ASPECT_FLOOR_DB = -65.0  # centres that are left out, at other moments others
MAX_CURVES_DB = 1.0  # beyond it bends are more likely edges than curves: no number is given
SHADOW_SHARE = 0.03  # of a facet: rms error of where a shadow of the body's own parts ends (physical_optics.shadow_edges)
TURNED_DB, WIDE_DB = 0.2, 0.4  # declared bodies between two visibility steps: within the beam, and wider than it
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
    model = scattering_model(body, fidelity.sampler)
    power = model.error_db(body, scene, fidelity, scatterers)
    remarks: list[str] = []
    if issubclass(model, FixedScatterers) and scene.environment.multipath:
        remarks += _split_paths(body, scene)
    if body.mesh is None or power is None:
        return BodyError(power, None, tuple(remarks))
    run = body_run(body, scene)
    if issubclass(model, PhysicalOptics):
        more, sentences = _optics(body, scene, run)
        aspects = aspect_db(body, scene, run)
        return BodyError(math.hypot(power, more), aspects if math.isfinite(aspects) else None, (*sentences, *remarks))
    if issubclass(model, DeclaredScattering):
        more, sentences = _declared(body, scene, run, scatterers)
    elif issubclass(model, DiffuseScattering):
        more, sentences = _diffuse(body, scene, fidelity, run, scatterers)
    else:
        more, sentences = 0.0, []
    return BodyError(math.hypot(power, more), None, (*sentences, *remarks))


def aspects_db(scene: Scene) -> float:
    """Predicted relative field error [dB] of interpolating physical optics between aspects: the worst of all bodies at any time
    of the run; -inf where no aspect changes."""
    metal = [body for body in scene.bodies if issubclass(scattering_model(body), PhysicalOptics)]
    return max((aspect_db(body, scene, body_run(body, scene)) for body in metal), default=-math.inf)


def aspect_db(body: Body, scene: Scene, run: BodyRun) -> float:
    """As `aspects_db`, of one body: an error of second order in the phase that its echoes turn while the main beam passes."""
    assert body.mesh is not None
    rate = run.turn + (run.sea_turn if scene.environment.multipath else 0.0)
    radar, limits = scene.radar, edge_limits(scene.radar, body.mesh)
    size = min(max(limits.at(max(run.nearest, NEAREST))), body.diagonal)
    turned = 2.0 * np.pi / radar.wavelength * size * rate * radar.rotation_period * radar.beamwidth / (2.0 * np.pi)
    if turned == 0.0:
        return -math.inf
    error = min(HELD * (turned / HELD_PHASE) ** 2, NODES * MAX_PHASE**2)
    return combine_db(20.0 * math.log10(error), ASPECT_FLOOR_DB)


def _optics(body: Body, scene: Scene, run: BodyRun) -> tuple[float, list[str]]:
    """Errors [dB] of facets at the closest approach, beyond those of plates and corners."""
    assert body.mesh is not None
    distance, radar = max(run.nearest, NEAREST), scene.radar
    times, edge = facet_enlargement(body, radar, distance), edge_limits(radar, body.mesh).longest_edge(distance)
    size = body.diagonal
    shadow = SHADOW_SHARE / math.sqrt(2.0) * min(1.0, times * edge / size) ** 1.5
    errors, remarks = [20.0 * math.log10(1.0 + shadow)], []
    if times > 1.0:
        errors.append(FACETS_DB * times**2)
    if times > 1.0 and times > facet_enlargement(body, radar, max(run.start - body.radius, NEAREST)):
        remarks.append(f"at its closest, {run.nearest:.0f} m, facets are {times:.1f} times too long: {errors[-1]:.1g} dB")
    sag = curve_sag(body.mesh)
    curves = CURVES_DB * sag / (MAX_SAG * radar.wavelength)
    if 0.0 < curves <= MAX_CURVES_DB:
        errors.append(curves)
        remarks.append(f"curves sag by {length_text(sag)}: {curves:.1g} dB")
    elif curves > MAX_CURVES_DB:
        remarks.append(f"bends that are meant as curves sag by {length_text(sag)} and err by over {MAX_CURVES_DB:.0f} dB")
    return math.hypot(*errors), remarks


def _declared(body: Body, scene: Scene, run: BodyRun, scatterers: int | None) -> tuple[float, list[str]]:
    """The energy of a declared body between two visibility steps; at each of them it is exact."""
    if scatterers == 1 or run.turn == 0.0:
        return 0.0, []
    wide = 2.0 * body.radius > cell_spacing(scene.radar).azimuth * max(run.approach, NEAREST)
    remark = "at its closest it is wider than the beam; " if wide else ""
    return WIDE_DB if wide else TURNED_DB, [f"{remark}its phases change at each visibility step, its energy does not"]


def _diffuse(body: Body, scene: Scene, fidelity: Fidelity, run: BodyRun, scatterers: int | None) -> tuple[float, list[str]]:
    """What a surface loses by coming nearer than it was when its scatterers were drawn: its cells have fewer."""
    if run.approach >= run.start:
        return 0.0, []
    radar, before = scene.radar, density_db(fidelity.scatterers_per_cell)
    start, closest = (max(radar.beamwidth * distance, radar.range_step) for distance in (run.start, run.approach))
    there = fidelity.scatterers_per_cell * closest / start
    if scatterers is not None:
        there = max(there, scatterers / max(1.0, body.length * body.beam / (closest * radar.range_step)))
    after = density_db(there)
    if after <= before:
        return 0.0, []
    text = f"at its closest, {run.nearest:.0f} m, {there:.2g} scatterers per resolution cell"
    return math.sqrt(after**2 - before**2), [f"{text}: {after:.2g} dB"]


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
