"""Judges the sizes of bodies before anything is computed of them: most that are wrong are meshes in other units than metres."""

from collections.abc import Iterator

from radar_service.numerics.types import Floats
from radar_service.scattering.surface_sampling import normals_and_areas
from radar_service.scene_file.model.ais import TransponderModel
from radar_service.scene_file.model.body import BodyOfAKind, HeightMapBodyModel, ShapeBodyModel
from radar_service.world.body import Mesh
from radar_service.world.error import SceneError

LONGEST, SHORTEST = 500.0, 1.0  # m: the longest ship had 458 m
HIGHEST = dict.fromkeys(("building", "urban", "concrete", "brick", "glass"), 1000.0)  # m: the highest building has 828 m
HIGHEST_LAND = 9000.0  # m: the highest mountain has 8849 m
DIFFERENT = 1.25  # times: AIS tells whole metres, and some meshes leave out a bowsprit or a bulb
MAX_OPTICS_AREA = (
    1e6  # m^2 of what is longer than LONGEST: 100 m off a scan takes 54 s, 1.1 GB; the largest ship has 0.2 km2
)
SCALE = "set scale to the metres per unit of the file (0.001 for mm, 0.0254 for inches, 0.3048 for feet)"


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
