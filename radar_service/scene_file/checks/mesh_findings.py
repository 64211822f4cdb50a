"""Sentences about mesh files and height maps: warnings of what is missing, notes on what needs no action.

The engine computes open and inconsistent meshes as they are. What many meshes have in common is one note.
"""

from collections.abc import Callable, Iterator, Sequence

MISSING = "without data become sea"  # how the finding of a height map with holes ends, see readers.raster
OPEN = "not watertight"  # how the finding of a surface with open edges begins, see readers.mesh
NAMED = 2  # meshes that a common sentence names

Findings = tuple[str, str, Sequence[str]]  # key path of a body's mesh, name of its file, findings in words without a subject


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
