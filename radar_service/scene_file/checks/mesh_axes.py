"""Findings about how a mesh file stands in its scene: which of its axes is up, and which one is her bow."""

import numpy as np

from radar_service.scene_file.model.body import MeshBodyModel
from radar_service.world.body import Mesh

ACROSS = 1.5  # times as wide as long: no ship is, so her bow points along x in the file
SIDEWAYS_DEG = 45.0  # of drift, from which on somebody has turned the mesh already


def axis_findings(body: MeshBodyModel, mesh: Mesh) -> tuple[str, ...]:
    """Findings about the axes of a body's mesh file, in words without a subject."""
    return (*_up_axis(body), *_bow_axis(body, mesh))


def _up_axis(body: MeshBodyModel) -> tuple[str, ...]:
    """The standard of GLB says that y is up; a scene says z unless told otherwise."""
    if "up" in body.model_fields_set or not body.mesh.lower().endswith(".glb"):
        return ()
    return ('taken with z up, though y is up in GLB by its standard: set up = "y", or up = "z" if this file has z up',)


def _bow_axis(body: MeshBodyModel, mesh: Mesh) -> tuple[str, ...]:
    """A mesh that is under way by its side: files of robots and of naval architects have the bow along x."""
    across, along = np.ptp(mesh.vertices[:, :2], axis=0)
    turned = body.heading_deg is not None or abs(body.drift_deg) >= SIDEWAYS_DEG
    if turned or across <= ACROSS * along or not (body.speed_kn or body.waypoints or body.track):
        return ()
    return (
        f"under way by its side: {across:.3g} m across and {along:.3g} m along, bows point along y: drift_deg = 90 turns one "
        "along x",
    )
