"""Sentences about mesh files and height maps: warnings of what is missing or of odd size, how a ship is turned and floats, notes.

The engine computes open and inconsistent meshes as they are. What many meshes have in common is one note.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from radar_service.numerics import Floats
from radar_service.scattering import normals_and_areas
from radar_service.scene_file.model.ais import TransponderModel
from radar_service.scene_file.model.body import BodyModel, BodyOfAKind, HeightMapBodyModel, MeshBodyModel, ShapeBodyModel
from radar_service.world import VESSEL_MATERIALS, Mesh, SceneError

MISSING = "without data become sea"  # how the finding of a height map with holes ends, see readers.raster
OPEN = "not watertight"  # how the finding of a surface with open edges begins, see readers.mesh
NAMED = 2  # meshes that a common sentence names

Findings = tuple[str, str, Sequence[str]]  # key path of a body's mesh, name of its file, findings in words without a subject
LONGEST, SHORTEST = 500.0, 1.0  # m: the longest ship had 458 m
HIGHEST = dict.fromkeys(("building", "urban", "concrete", "brick", "glass"), 1000.0)  # m: the highest building has 828 m
HIGHEST_LAND = 9000.0  # m: the highest mountain has 8849 m
DIFFERENT = 1.25  # times: AIS tells whole metres, and some meshes leave out a bowsprit or a bulb
MAX_OPTICS_AREA = 1e6  # m^2 of what is longer than LONGEST: 100 m off a scan takes 54 s; the largest ship has 0.2 km2
SCALE = "set scale to the metres per unit of the file (0.001 for mm, 0.0254 for inches, 0.3048 for feet)"
ACROSS = 1.5  # times as wide as long: no ship is, so its bow points along x in the file
SIDEWAYS_DEG = 45.0  # of drift, from which on somebody has turned the mesh already
DEEPEST = 0.5  # share of a ship's height that is under water


def mesh_warnings(meshes: Sequence[Findings], hints: Sequence[Findings] = ()) -> Iterator[str]:
    """Yields a warning for all hints about the same file or shape, and for each height map of which a part is missing."""
    yield from _sentences(hints, lambda hint: True)
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


def size_findings(body: BodyOfAKind, size: Floats, is_afloat: bool) -> Iterator[str]:
    """Yields what is wrong with the size (3,) [m] of a body across, along and up, in words without a subject.

    is_afloat: whether it floats or moves.
    """
    across, along, up = size.tolist()
    length, remedy = max(across, along), _remedy(body)
    if is_afloat and (length > LONGEST or (length < SHORTEST and remedy is SCALE)):
        yield f"{metres(length)} m long, and ships have {SHORTEST:g} to {LONGEST:g} m: {remedy}"
    elif up > (highest := HIGHEST.get(body.material, HIGHEST_LAND)):
        yield f"{metres(up)} m high, and no {body.material} has more than {highest:g} m: {remedy}"
    yield from _other_than_ais(body.ais or TransponderModel(), across, along, remedy)


def _other_than_ais(ais: TransponderModel, across: float, along: float, remedy: str) -> Iterator[str]:
    for key, stated, size in (("length_m", ais.length_m, along), ("beam_m", ais.beam_m, across)):
        if stated and not 1.0 / DIFFERENT <= size / stated <= DIFFERENT:
            yield f"{metres(size)} m where ais.{key} is {stated:g} m: {remedy}, or correct ais.{key}"


def check_optics_area(body: BodyOfAKind, mesh: Mesh, size: Floats, location: str) -> None:
    """Raises SceneError for a body by physical optics that has too much surface: its cut edges and lattice grow with that."""
    if max(size) <= LONGEST or (area := float(normals_and_areas(mesh)[1].sum())) <= MAX_OPTICS_AREA:
        return
    raise SceneError(
        f"{location}: {body.name} is {metres(max(size))} m large, with {metres(area / 1e6)} km2 of {body.material}; at most "
        f"{MAX_OPTICS_AREA / 1e6:g} km2 of such a body are computed by physical optics: {_remedy(body)}, or give "
        'scattering = "diffuse"'
    )


def _remedy(body: BodyOfAKind) -> str:
    """Which keys correct the size of a body, or what it is made of."""
    if isinstance(body, HeightMapBodyModel):
        return 'set material = "land"'
    return f"correct {', '.join(body.sizes())}" if isinstance(body, ShapeBodyModel) else SCALE


def metres(length: float) -> str:
    """Returns a length [m] in words, without exponents."""
    return f"{length:.3g}" if length < 100.0 else f"{length:.0f}"


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
