"""Findings about a mesh as a ship: which way it is turned, how deep it floats; in words without a subject."""

from collections.abc import Iterator

import numpy as np

from radar_service.scene_file.model.body import BodyModel, MeshBodyModel
from radar_service.world.body import Mesh
from radar_service.world.materials import VESSEL_MATERIALS

ACROSS = 1.5  # times as wide as long: no ship is, so its bow points along x in the file
SIDEWAYS_DEG = 45.0  # of drift, from which on somebody has turned the mesh already
DEEPEST = 0.5  # share of a ship's height that is under water


def axis_findings(body: MeshBodyModel, mesh: Mesh, height: float = 0.0) -> tuple[str, ...]:
    """Findings about the axes of a body's mesh, which is in the frame of the body, the worst first.

    height: of the origin of that frame above the sea [m].
    """
    size = np.ptp(mesh.vertices, axis=0)
    across, along, up = size.tolist()
    findings = [*_taller_than_long(body, along, across, up), *_bow_axis(body, across, along)]
    if body.material in VESSEL_MATERIALS:
        findings += _draught(-height - float(mesh.vertices[:, 2].min()), up)
    return (*findings, *_up_axis(body))


def _up_axis(body: MeshBodyModel) -> Iterator[str]:
    """The standard of GLB says that y is up; a scene says z unless told otherwise."""
    if "up" not in body.model_fields_set and body.mesh.lower().endswith(".glb"):
        yield 'taken with z up, though y is up in GLB by its standard: set up = "y", or up = "z" if this file has z up'


def _bow_axis(body: MeshBodyModel, across: float, along: float) -> Iterator[str]:
    """A mesh that is under way by its side: files of robots and of naval architects have the bow along x."""
    turned = body.heading_deg is not None or abs(body.drift_deg) >= SIDEWAYS_DEG
    if is_under_way(body) and not turned and across > ACROSS * along:
        yield (
            f"under way by its side: {across:.3g} m across and {along:.3g} m along, bows point along y: "
            f"mesh_heading_deg = {(body.mesh_heading_deg + 90.0) % 360.0:g} turns one along x"
        )


def _taller_than_long(body: MeshBodyModel, along: float, across: float, up: float) -> Iterator[str]:
    if is_under_way(body) and up > max(along, across):
        other = "z" if body.up == "y" else "y"
        yield (
            f"under way on end: {up:.3g} m high and {max(along, across):.3g} m long: "
            f'set up = "{other}" if {other} is up in this file'
        )


def _draught(draught: float, up: float) -> Iterator[str]:
    """draught: of the lowest vertex below the sea [m]; up: from the lowest to the highest one [m]."""
    if draught > DEEPEST * up:
        yield f"{draught:.3g} of {up:.3g} m under water: raise it by mesh_offset_m, or by the third number of position_m"


def is_under_way(body: BodyModel) -> bool:
    """Whether a body moves from its place."""
    return bool(body.speed_kn or body.waypoints or body.track)
