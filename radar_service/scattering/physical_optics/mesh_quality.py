"""Mesh quality for physical optics, as `check` reports it: facet sizes, concavity, curvature."""

import math
from collections.abc import Mapping

import numpy as np

from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.facets import MAX_FACETS
from radar_service.scattering.physical_optics.optical_body import edge_limits, facet_enlargement
from radar_service.scattering.physical_optics.patches import COPLANAR, concave_sides, outward_side, shared_edges
from radar_service.scene.body import Body, Mesh
from radar_service.scene.world import Scene

MAX_CURVE_BEND = math.radians(30.0)  # between facets: less may approximate a curve, more is an edge
MAX_SAG, CURVES_DB = (
    1.0 / 200.0,
    0.2,
)  # of the wavelength, 0.16 mm at X band: curves that sag so err by about 0.2 dB (scene/shapes.py)


def mesh_quality(scene: Scene, bounces: int, nearest: Mapping[str, float]) -> dict[str, list[str]]:
    """Sentences about each body by physical optics, by its name; nearest: least distance over the run [m], by name."""
    return {
        body.name: _body_quality(body, body.mesh, scene, bounces, nearest[body.name])
        for body in scene.bodies
        if body.scattering == "optics" and body.mesh is not None
    }


def _body_quality(body: Body, mesh: Mesh, scene: Scene, bounces: int, distance: float) -> list[str]:
    limit = edge_limits(scene.radar, mesh).longest_edge(distance)
    corners = mesh.vertices[mesh.faces]
    longest = float(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max())
    cut = f", cut to {limit:.3g} m" if longest > limit else ""
    sentences = [f"optics: facets up to {longest:.3g} m long{cut}; {_concavity(mesh, bounces)}"]
    return sentences + _curves(mesh, scene.radar) + _enlargement(body, scene.radar, distance)


def _concavity(mesh: Mesh, bounces: int) -> str:
    facing = concave(mesh)
    if not facing:
        return "convex: no facet reflects onto another"
    return f"concave: {facing} of {len(mesh.faces)} facets face others, up to {bounces} bounces are computed"


def concave(mesh: Mesh) -> int:
    """How many triangles have a part of the body in front of an outer side of theirs."""
    may_rebounce, outside = concave_sides(mesh), outward_side(mesh)
    return int(np.count_nonzero((may_rebounce[:, 0] & (outside >= 0)) | (may_rebounce[:, 1] & (outside <= 0))))


def _curves(mesh: Mesh, radar: Radar) -> list[str]:
    sag, limit = curve_sag(mesh), MAX_SAG * radar.wavelength
    if sag == 0.0:
        return []
    if sag <= limit:
        return [f"curves sag by at most {1e3 * sag:.2g} mm, fine at a wavelength of {1e3 * radar.wavelength:.3g} mm"]
    return [
        f"bends below {math.degrees(MAX_CURVE_BEND):.0f} degrees, if they approximate curves, leave facets up to "
        f"{1e3 * sag:.3g} mm off them; beyond {1e3 * limit:.2g} mm, 1/200 of the wavelength, curves err by over 0.2 dB: refine "
        "those that matter"
    ]


def curve_sag(mesh: Mesh) -> float:
    """The greatest distance [m] of a facet from the curve that it and its neighbours approximate; 0 where nothing is curved.

    The sum over its edges of bend x height over the edge / 8: that of a strip of a cylinder, bent at both sides of its two
    triangles, exactly; of an equilateral triangle on a sphere 9/8 of e^2 / (6 r).
    """
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.maximum(np.linalg.norm(cross, axis=1), 1e-300)
    normal = cross / double[:, None]
    height = double[:, None] / np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    pairs = np.stack(shared_edges(mesh))
    one, other = normal[pairs // 3]
    bend = np.arcsin(np.minimum(np.linalg.norm(np.cross(one, other), axis=1), 1.0))  # whichever way each is wound
    curved = (bend > COPLANAR) & (bend < MAX_CURVE_BEND)
    sag = np.zeros(len(normal))
    for edge in pairs[:, curved]:
        np.add.at(sag, edge // 3, bend[curved] * height.ravel()[edge] / 8.0)
    return float(sag.max(initial=0.0))


def _enlargement(body: Body, radar: Radar, distance: float) -> list[str]:
    times = facet_enlargement(body, radar, distance)
    if times == 1.0:
        return []
    return [
        f"too large for fine facets: at most {MAX_FACETS}, {times:.1f} times longer than they should be, so that echoes spread "
        "over a cell or two and flashes at short range are too bright; split the body or declare rcs_dbsm"
    ]
