"""What `check` says of bodies by physical optics: whether their facets serve, and what mirrors into what."""

import math

import numpy as np

from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.facets import MAX_FACETS
from radar_service.scattering.physical_optics.optical_body import facet_enlargement, longest_edge
from radar_service.scattering.physical_optics.patches import COPLANAR, faces_something, outward_side, shared_edges
from radar_service.scene.world import Body, Mesh, Scene

SMOOTH = math.radians(30.0)  # a bend of less than this between facets may stand for a curve, more is an edge
FINE = 1.0 / 50.0  # of the wavelength, 0.6 mm at X band: curves that sag no more err by 0.5 dB at most (scene/shapes.py)


def mesh_quality(scene: Scene, bounces: int) -> dict[str, list[str]]:
    """A few sentences on each body by physical optics, by its name, where it stands at t = 0."""
    return {
        body.name: _remarks(body, body.mesh, scene, bounces)
        for body in scene.bodies
        if body.scattering == "optics" and body.mesh is not None
    }


def _remarks(body: Body, mesh: Mesh, scene: Scene, bounces: int) -> list[str]:
    distance = math.dist(body.middle_at(0.0), scene.antenna(0.0)[0]) - body.radius
    limit = longest_edge(distance, scene.radar.range_resolution, scene.radar.wavelength)
    corners = mesh.vertices[mesh.faces]
    longest = float(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max())
    cut = f", cut to {limit:.3g} m" if longest > limit else ""
    messages = [f"optics: facets up to {longest:.3g} m long{cut}; {_mirrors(mesh, bounces)}"]
    return messages + _curves(mesh, scene.radar) + _coarser(body, scene.radar, distance)


def _mirrors(mesh: Mesh, bounces: int) -> str:
    facing = concave(mesh)
    if not facing:
        return "convex: no facet mirrors into another"
    return f"concave: {facing} of {len(mesh.faces)} facets face others, up to {bounces} bounces are followed"


def concave(mesh: Mesh) -> int:
    """How many triangles have any part of the body before a side of theirs that is not its inside."""
    may_rebounce, outside = faces_something(mesh), outward_side(mesh)
    return int(np.count_nonzero((may_rebounce[:, 0] & (outside >= 0)) | (may_rebounce[:, 1] & (outside <= 0))))


def _curves(mesh: Mesh, radar: Radar) -> list[str]:
    sag, requested = curve_sag(mesh), FINE * radar.wavelength
    if sag == 0.0:
        return []
    if sag <= requested:
        return [f"curves are kept to {1e3 * sag:.2g} mm, fine at a wavelength of {1e3 * radar.wavelength:.3g} mm"]
    return [
        f"bends below {math.degrees(SMOOTH):.0f} degrees, if they stand for curves, leave facets up to {1e3 * sag:.3g} mm off "
        f"them; beyond {1e3 * requested:.2g} mm, 1/50 of the wavelength, curves err by over 0.5 dB: refine those that matter"
    ]


def curve_sag(mesh: Mesh) -> float:
    """How far [m] at most a facet lies from the curve that it and its neighbours stand for, 0 where nothing is curved.

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
    curved = (bend > COPLANAR) & (bend < SMOOTH)
    sag = np.zeros(len(normal))
    for edge in pairs[:, curved]:
        np.add.at(sag, edge // 3, bend[curved] * height.ravel()[edge] / 8.0)
    return float(sag.max(initial=0.0))


def _coarser(body: Body, radar: Radar, distance: float) -> list[str]:
    times = facet_enlargement(body, radar, distance)
    if times == 1.0:
        return []
    return [
        f"too large to be cut so fine: at most {MAX_FACETS} pieces, {times:.1f} times longer than they should be, so that echoes "
        "spread over a cell or two and flashes near by are too bright; split the body or declare rcs_dbsm"
    ]
