"""Warns of defects of mesh files. What many meshes have in common is one warning."""

from collections.abc import Iterator, Sequence

OPEN = "not watertight"  # how the defect of a surface with open edges begins, see scene.files.mesh
NAMED = 2  # meshes that a common warning names

Defects = tuple[str, str, Sequence[str]]  # key path of a body's mesh, name of its file, defects in words without a subject


def mesh_warnings(meshes: Sequence[Defects]) -> Iterator[str]:
    """Yields a warning for each mesh with defects, but one for all that are not watertight where these are several."""
    open_ones = [location for location, _, defects in meshes if any(map(_is_open, defects))]
    several = len(open_ones) > 1
    for location, name, defects in meshes:
        own = [defect for defect in defects if not (several and _is_open(defect))]
        if own:
            yield f"{location}: {name}: {', '.join(own)}"
    if several:
        more = f" and {len(open_ones) - NAMED} more" if len(open_ones) > NAMED else ""
        yield f"{len(open_ones)} meshes are {OPEN}: {', '.join(open_ones[:NAMED])}{more}"


def _is_open(defect: str) -> bool:
    return defect.startswith(OPEN)
