"""Mesh quality for physical optics, as `check` reports it: facet sizes, concavity, sides, curvature."""

import math

import numpy as np
from numpy.typing import NDArray

from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.patches import COPLANAR, concave_sides, outward_side, shared_edges
from radar_service.world.body import Body, Mesh
from radar_service.world.large_mesh import mesh_sample, outward_winding

Sides = NDArray[np.int8]
MAX_CURVE_BEND = math.radians(30.0)  # between facets: less may approximate a curve, more is an edge
MAX_SAG, CURVES_DB = (
    1.0 / 200.0,
    0.2,
)  # of the wavelength, 0.16 mm at X band: curves that sag so err by about 0.2 dB (world/shapes.py)


def mesh_quality(body: Body, radar: Radar, bounces: int, distance: float) -> list[str]:
    """Sentences about a body by physical optics at its least distance over the run [m]."""
    assert body.mesh is not None
    mesh, large = mesh_sample(body.mesh), list[str]()
    if mesh is body.mesh:
        outside = outward_side(mesh)
    else:
        outside = np.full(len(mesh.faces), outward_winding(body.mesh), dtype=np.int8)
        large = [f"these are remarks on {len(mesh.faces)} of {len(body.mesh.faces)} facets, in slices across the body"]
    corners, facing = mesh.vertices[mesh.faces], concave(mesh, outside)
    longest = float(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max())
    sentences = [f"optics: facets up to {longest:.3g} m long; {_concavity(facing, len(mesh.faces), bounces)}"]
    return sentences + _sides(outside) + _curves(mesh, radar) + large


def _concavity(facing: int, count: int, bounces: int) -> str:
    if not facing:
        return "convex: no facet reflects onto another"
    return f"concave: {facing} of {count} facets face others, up to {bounces} bounces are computed"


def _sides(outside: Sides) -> list[str]:
    """What is lit where the file does not tell the outside: nothing is lost, but inner walls can be lit too."""
    unknown = int(np.count_nonzero(outside == 0))
    if unknown == 0:
        return []
    return [
        f"{unknown} of {len(outside)} facets belong to parts that are open or wound both ways: both their sides reflect; close "
        "a hull, so that no inner wall reflects through a gap"
    ]


def concave(mesh: Mesh, outside: Sides) -> int:
    """How many triangles have a part of the body in front of an outer side of theirs; outside: (F,) as from `outward_side`."""
    may_rebounce = concave_sides(mesh)
    return int(np.count_nonzero((may_rebounce[:, 0] & (outside >= 0)) | (may_rebounce[:, 1] & (outside <= 0))))


def _curves(mesh: Mesh, radar: Radar) -> list[str]:
    sag, limit = curve_sag(mesh), MAX_SAG * radar.wavelength
    if sag == 0.0:
        return []
    if sag <= limit:
        return [f"curves sag by at most {length_text(sag)}, fine at a wavelength of {1e3 * radar.wavelength:.3g} mm"]
    return [
        f"bends below {math.degrees(MAX_CURVE_BEND):.0f} degrees, if they approximate curves, leave facets up to "
        f"{length_text(sag)} off them; beyond {1e3 * limit:.2g} mm, 1/200 of the wavelength, curves err by over 0.2 dB: refine "
        "those that matter"
    ]


def length_text(length: float) -> str:
    """A length [m] in words: in millimetres below a metre."""
    return f"{1e3 * length:.3g} mm" if length < 1.0 else f"{length:.3g} m"


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
    normal_a, normal_b = normal[pairs // 3]
    bend = np.arcsin(np.minimum(np.linalg.norm(np.cross(normal_a, normal_b), axis=1), 1.0))  # whichever way each is wound
    curved = (bend > COPLANAR) & (bend < MAX_CURVE_BEND)
    sag = np.zeros(len(normal))
    for edge in pairs[:, curved]:
        np.add.at(sag, edge // 3, bend[curved] * height.ravel()[edge] / 8.0)
    return float(sag.max(initial=0.0))
