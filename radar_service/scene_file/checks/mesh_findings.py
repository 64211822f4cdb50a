"""Sentences about mesh files and height maps: warnings of what is missing, notes on what needs no action, odd axes of meshes.

The engine computes open and inconsistent meshes as they are. What many meshes have in common is one note.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from radar_service.scene_file.model.body import MeshBodyModel
from radar_service.world.body import Mesh

MISSING = "without data become sea"  # how the finding of a height map with holes ends, see readers.raster
OPEN = "not watertight"  # how the finding of a surface with open edges begins, see readers.mesh
NAMED = 2  # meshes that a common sentence names

Findings = tuple[str, str, Sequence[str]]  # key path of a body's mesh, name of its file, findings in words without a subject


def mesh_warnings(meshes: Sequence[Findings]) -> Iterator[str]:
    """Yields a warning for each height map of which a part is missing."""
    yield from _sentences(meshes, lambda finding: finding.endswith(MISSING))


def mesh_notes(meshes: Sequence[Findings]) -> Iterator[str]:
    """Yields a note for each file with other findings, but one for all that are not watertight where these are several."""
    open_ones = [location for location, _, findings in meshes if any(map(_is_open, findings))]
    several = len(open_ones) > 1
    yield from _sentences(meshes, lambda f: not f.endswith(MISSING) and not (several and _is_open(f)))
    if several:
        yield f"{len(open_ones)} meshes are {OPEN}: {_named(open_ones)}"


def _sentences(meshes: Sequence[Findings], concerns: Callable[[str], bool]) -> Iterator[str]:
    """Yields a sentence for each file with such findings, however many bodies have it."""
    bodies: dict[tuple[str, str], list[str]] = {}
    for location, name, findings in meshes:
        chosen = ", ".join(finding for finding in findings if concerns(finding))
        if chosen:
            bodies.setdefault((name, chosen), []).append(location)
    for (name, chosen), locations in bodies.items():
        yield f"{_named(locations)}: {name}: {chosen}"


def _named(locations: Sequence[str]) -> str:
    more = f" and {len(locations) - NAMED} more" if len(locations) > NAMED else ""
    return f"{', '.join(locations[:NAMED])}{more}"


def _is_open(finding: str) -> bool:
    return finding.startswith(OPEN)


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
