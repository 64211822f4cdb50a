"""Slow reference: the field of ships of boxes under way, spoke by spoke, sharing no code with the engine.

Each spoke has its own poses, its own shadows, and vector physical optics by elements of all four paths (`metal_on_water`).
"""

from typing import NamedTuple

import numpy as np

from tests.reference import metal_on_water as oracle
from tests.reference import ship_tracks
from tests.reference.cast_shadows import Piece, in_front, lit_pieces
from tests.reference.metal_draws import GAIN, POWER, compressed
from tests.reference.metal_on_water import Contributions, Face, Floats
from tests.reference.ship_draws import AZIMUTHS, STEP, Case, Table

SHADOWED = 0.03  # of the field without shadows: what is left of less is the far edge of a shadow
CELLS_AROUND = 3.0  # of range about the bodies that are compared


class Solid(NamedTuple):
    """The faces of a body about the foot of the antenna, and whether they are of metal."""

    faces: list[Floats]
    metal: bool


def solid(table: Table, time: float, own: Floats, case: Case) -> Solid:
    """A box at a time [s]; own: position (3,) of the antenna's foot [m]."""
    stand = ship_tracks.stand(table, time, case.tracks)
    x, y, z = table["width_m"] / 2.0, table["length_m"] / 2.0, table["height_m"]
    foot = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
    top = foot + (0.0, 0.0, z)
    rings = [np.array([foot[i], foot[(i + 1) % 4], top[(i + 1) % 4], top[i]]) for i in range(4)]
    faces = [ring @ stand.rotation.T + stand.position - own for ring in (*rings, top, foot[::-1])]
    return Solid(faces, "rcs_dbsm" not in table)


def contributions(case: Case, time: float, size: float | None = None, shadows: bool = True) -> list[Contributions]:
    """What all metal returns at a time [s]. size: of equal elements [m]; None: of as many as the phase needs. shadows: whether
    bodies cast shadows on each other."""
    own = ship_tracks.stand(case.own, time, case.tracks).position
    solids, setting = [solid(table, time, own, case) for table in case.bodies], case.setting
    result = []
    for body in solids:
        if not body.metal:
            continue
        others = [each.faces for each in solids if each is not body] if shadows else []
        before = [in_front(other, body.faces) for other in others]
        middle = np.concatenate(body.faces).mean(axis=0)[:2]
        for face in body.faces:
            if oracle.may_be_lit(Face(face), setting):
                for piece in lit_pieces(oracle.dry(face), others, before, middle / np.hypot(*middle), setting):
                    result += of_piece(piece, case, size)
    return result


def of_piece(piece: Piece, case: Case, size: float | None) -> list[Contributions]:
    """What a part of a face returns by the ways that reach it."""
    kept = np.array([piece.direct, piece.direct and piece.sea, piece.sea])[:, None]
    result = []
    for quad in oracle.quadrangles(piece.corners):
        elements = oracle.smooth_elements(quad, case.setting) if size is None else oracle.equal_elements(quad, size)
        for part in oracle.chunks(elements):
            returned = oracle.contributions(part, False, case.setting)
            result.append(returned._replace(amplitude=np.where(kept, returned.amplitude, 0.0)))
    return result


def field(case: Case, ranges: Floats, spokes: np.ndarray, size: float | None = None, shadows: bool = True) -> np.ndarray:
    """The field (K, N) [sqrt(W)] at samples `ranges` (N,) [m] of spokes (K,), numbered from the start; size, shadows: as of
    `contributions`."""
    level = np.sqrt(POWER * GAIN**2 * case.setting.wavelength**2 / (4.0 * np.pi) ** 3)
    beamwidth, bandwidth = np.deg2rad(case.radar["beamwidth_deg"]), case.radar["bandwidth_hz"]
    rows = []
    for spoke in spokes.tolist():
        boresight = 2.0 * np.pi * spoke / AZIMUTHS
        rows.append(compressed(contributions(case, spoke * STEP, size, shadows), ranges, boresight, beamwidth, bandwidth))
    return np.asarray(level * np.array(rows))


def level(case: Case, ranges: Floats, exact: np.ndarray) -> float:
    """What errors are relative to [sqrt(W)]: the largest cell of a passage (K, N), or SHADOWED of what it is without shadows."""
    largest = float(np.abs(exact).max())
    if len(case.bodies) == 1:
        return largest
    return max(largest, SHADOWED * float(np.abs(field(case, ranges, case.spokes[::2], shadows=False)).max()))


def cells(case: Case, step: float, count: int) -> np.ndarray:
    """Indices of the range cells about the bodies, of `count` cells of a length [m]."""
    time = case.crossing * STEP
    own = ship_tracks.stand(case.own, time, case.tracks).position
    metal = [ship_tracks.stand(t, time, case.tracks).position - own for t in case.bodies if "rcs_dbsm" not in t]
    slant = [np.hypot(np.hypot(*position[:2]), case.setting.antenna_height) for position in metal]
    margin = CELLS_AROUND * oracle.LIGHT / (2.0 * case.radar["bandwidth_hz"]) + 10.0
    first, last = (min(slant) - margin) / step, (max(slant) + margin) / step
    return np.arange(max(0, int(first)), min(count, int(last)))
