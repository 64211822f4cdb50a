"""Ships of many triangles by planes against brute force, at random aspects.

    .venv/bin/python -m tests.measurements.hull_errors FILE [--count N] [--only KIND ...]

Sizes of hull types, their seeds, and distances are drawn: 0.5 to 5 km evenly in the logarithm. Each draw is in X or S band, H or
V, over the sea or in free space; half of them lean by up to 15 and 5 degrees, a quarter stand behind another hull. What range
cells of 7.5 m see of the scattering centres of `OpticalBody` is compared with `tests/reference/narrow_beams.py`. Where both
differ by more than AGAIN of the largest cell, the brute force is taken anew with half as wide cells; every tenth draw has both,
for its own error. FILE keeps a line a draw, so that the study goes on where it was stopped; the table is of all that FILE has.
"""

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

import radar_service as rs
from radar_service.numerics.types import Complexes, Floats
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.cast_shadows import Onlooker
from radar_service.scattering.physical_optics.mesh_quality import outward_side
from radar_service.scattering.physical_optics.model import OpticalBody
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces
from radar_service.scattering.physical_optics.plane_echoes import EdgeLimits, PlaneOptics, Wave
from radar_service.scattering.physical_optics.scattering_centres import PATHS
from radar_service.trace.triangle_clusters import TriangleClusters
from radar_service.world.body import Mesh
from radar_service.world.poses import MAP_POSE, BodyPose
from radar_service.world.shapes import hull_mesh
from tests.reference import narrow_beams

SCENES = Path(__file__).parents[2] / "scenes"
# Length [m], from and to, and beam and height over it; a mesh has none
KINDS: dict[str, tuple[float, ...]] = {
    "pilot": (9.0, 18.0, 0.28, 0.36), "fishing": (9.0, 40.0, 0.22, 0.25), "yacht": (9.0, 24.0, 0.28, 0.25),
    "cargo": (75.0, 150.0, 0.16, 0.17), "ferry": (40.0, 120.0, 0.18, 0.18), "coaster.obj": (), "ferry.obj": (),
}  # fmt: skip
WIDTH, SHARE = 0.06, 0.0015  # m, and of the body's length: first cells of the brute force
AGAIN = 0.05
HIDDEN = 1e-6  # m: draws whose largest cell is less are wholly behind another ship
CELL, STEP = 7.5, 1.875  # m
BY_SEA = {"h": -0.8, "v": -0.5}  # coefficients of reflection


class Draw(NamedTuple):
    """mesh: leaning, the waterline at 0 where there is water. screens: another body's mesh and pose."""

    mesh: Mesh
    antenna: Floats
    water: float | None
    wavelength: float
    polarization: str
    lean: Floats
    screens: tuple[Mesh, BodyPose] | None

    @property
    def length(self) -> float:
        return float(np.ptp(self.mesh.used_vertices, axis=0).max())


def any_hull(kind: str, rng: np.random.Generator) -> Mesh:
    """A mesh of a kind: a hull type of any size, or a file."""
    if not KINDS[kind]:
        table = {"name": "ship", "position_m": [0, 2000.0, 0], "mesh": kind, "scattering": "optics"}
        scene = rs.load_scene({"radar": {"range_max_m": 6000}, "body": [table]}, folder=SCENES)
        mesh = scene.bodies[0].mesh
        assert mesh is not None
        return mesh
    low, high, beam, height = KINDS[kind]
    length = low * (high / low) ** rng.random()
    return hull_mesh(kind, int(rng.integers(1000)), length, length * beam, length * height)


def drawn(kind: str, number: int) -> Draw:
    """One draw, the same for the same number."""
    rng = np.random.default_rng([list(KINDS).index(kind), number])
    mesh = any_hull(kind, rng)
    distance, azimuth = 500.0 * 10.0 ** rng.random(), rng.uniform(0.0, 2.0 * np.pi)
    antenna = np.array([distance * np.sin(azimuth), distance * np.cos(azimuth), rng.uniform(5.0, 40.0)])
    lean = rng.uniform(-1.0, 1.0, 2) * (15.0, 5.0) * (rng.random() < 0.5)
    rotation = Rotation.from_euler("yx", lean, degrees=True).as_matrix()
    band, polarization, water = rng.choice([9.41e9, 3.05e9]), str(rng.choice(["h", "v"])), bool(rng.random() < 0.7)
    screens = None
    if rng.random() < 0.25:
        other = any_hull(str(rng.choice(["pilot", "fishing", "yacht", "cargo", "ferry"])), rng)
        across = np.array([np.cos(azimuth), -np.sin(azimuth), 0.0])
        ahead = max(
            rng.uniform(0.05, 0.7) * distance,
            (np.ptp(mesh.used_vertices, axis=0) + np.ptp(other.used_vertices, axis=0)).max(),
        )
        place = (
            ahead / distance * antenna * (1, 1, 0)
            + rng.uniform(-0.5, 0.5) * np.ptp(mesh.used_vertices, axis=0).max() * across
        )
        screens = other, BodyPose(place, rng.uniform(0.0, 2.0 * np.pi))
    return Draw(mesh, antenna, 0.0 if water else None, narrow_beams.LIGHT / band, polarization, rotation, screens)


def engine_body(draw: Draw) -> OpticalBody:
    wave = Wave(draw.wavelength, draw.polarization)
    optics = PlaneOptics.of(PlanarPieces.of(draw.mesh, outward_side(draw.mesh)), wave, 3, CELL)
    return OpticalBody(draw.mesh, optics, EdgeLimits(CELL, np.deg2rad(1.2), draw.wavelength, draw.length), 1.0).leaning(
        draw.lean
    )


def engine_cells(draw: Draw, body: OpticalBody, cells: Floats) -> tuple[Complexes, float]:
    """What range cells at half paths (N,) see, and the seconds that it took."""
    begin = time.process_time()
    pictures = tuple(Picture(draw.antenna, np.inf, by_sea) for by_sea in ((False,) if draw.water is None else (False, True)))
    shadows: Sequence[Any] = [None] * len(pictures)
    if draw.screens is not None:
        onlooker = Onlooker(body.dry_box(0.0), pictures)
        shadows = onlooker.shadows([(TriangleClusters(draw.screens[0]), draw.screens[1])])
    ways = tuple(
        BodyLeg(picture.by_sea, MAP_POSE, draw.antenna, np.inf, None, shadow)
        for picture, shadow in zip(pictures, shadows, strict=True)
    )
    total = np.zeros(len(cells), dtype=np.complex128)
    for path in body.echoes(ways, -np.inf if draw.water is None else draw.water):
        lengths = [leg.length(path.position) for leg in ways]
        out, back = PATHS[path.path]
        half = np.asarray((lengths[out] + lengths[back]) / 2.0)
        field = path.amplitude * np.exp(-4j * np.pi / draw.wavelength * half) * BY_SEA[draw.polarization] ** path.path
        total += seen_by_cells(cells, half, field)
    return total, time.process_time() - begin


def seen_by_cells(cells: Floats, half: Floats, field: Complexes) -> Complexes:
    return np.asarray(np.exp(-2.0 * np.log(2.0) * ((cells[:, None] - half) / CELL) ** 2) @ field)


def brute_cells(draw: Draw, cells: Floats, width: float, seed: int) -> Complexes:
    triangles = (draw.mesh.vertices @ draw.lean.T)[draw.mesh.faces]
    screens = (
        None if draw.screens is None else draw.screens[1].map_from_frame(draw.screens[0].vertices)[draw.screens[0].faces]
    )
    brute = narrow_beams.profile(
        triangles, draw.antenna, width, 3, draw.polarization, draw.water, draw.wavelength, seed, screens
    )
    return brute.cells(CELL, STEP, float(cells[0]), len(cells), BY_SEA[draw.polarization])


def measured(kind: str, number: int) -> dict[str, Any]:
    """Errors of one draw: of the largest cell, of any cell, both over the largest one, and of the power [dB]."""
    draw = drawn(kind, number)
    away = float(np.linalg.norm(draw.antenna))
    cells = np.arange(away - draw.length - 60.0, away + draw.length + 100.0, STEP)
    fields, seconds = engine_cells(draw, engine_body(draw), cells)
    width, begin = max(WIDTH, SHARE * draw.length), time.process_time()
    exact = brute_cells(draw, cells, width, 1)
    result: dict[str, Any] = {"kind": kind, "number": number, **compared(fields, exact)}
    result["seconds"] = [round(seconds, 4), round(time.process_time() - begin, 1)]
    if result["any"] > AGAIN or number % 10 == 0:
        finer = brute_cells(draw, cells, width / 2.0, 2)
        result |= compared(fields, finer) | {"brute": compared(exact, finer)}
    free, wave = draw.water is None, round(draw.wavelength, 3)
    posture = "upright" if np.allclose(draw.lean, np.eye(3)) else "leaning"
    place = "alone" if draw.screens is None else "behind"
    result["how"] = [round(draw.length), round(away), "free" if free else "sea", wave, draw.polarization, posture, place]
    return result


def compared(fields: Complexes, exact: Complexes) -> dict[str, float]:
    largest, at = float(np.abs(exact).max()), int(np.abs(exact).argmax())
    error = np.abs(fields - exact) / max(largest, 1e-9)
    power = 10.0 * np.log10(max(np.sum(np.abs(fields) ** 2), 1e-12) / max(np.sum(np.abs(exact) ** 2), 1e-12))
    return {"strongest": float(error[at]), "any": float(error.max()), "db": float(power), "largest": largest}


def table(rows: Sequence[dict[str, Any]]) -> str:
    lines = [
        "| ship | aspects | largest cell: median | 95 % | worst | any cell: median | 95 % | power rms dB | mean | worst |"
    ]
    lines.append("|" + "---|" * 10)
    for kind in [*KINDS, "all"]:
        some = [row for row in rows if kind in (row["kind"], "all") and row["largest"] > HIDDEN]
        if not some:
            continue
        strongest, anywhere, power = (np.array([row[key] for row in some]) for key in ("strongest", "any", "db"))
        parts = [*np.percentile(strongest, [50, 95]), strongest.max(), *np.percentile(anywhere, [50, 95])]
        decibels = [np.sqrt(np.mean(power**2)), power.mean(), power[np.abs(power).argmax()]]
        lines.append(
            f"| {kind} | {len(some)} | {' | '.join(f'{x:.3f}' for x in parts)} | {' | '.join(f'{x:.2f}' for x in decibels)} |"
        )
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measures what FILE has not, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--only", nargs="*", default=list(KINDS))
    options = parser.parse_args(arguments)
    rows = [json.loads(line) for line in options.file.read_text().splitlines()] if options.file.exists() else []
    there = {(row["kind"], row["number"]) for row in rows}
    for number in range(options.count):
        for kind in options.only:
            if (kind, number) not in there:
                rows.append(measured(kind, number))
                with options.file.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    print(table(rows))


if __name__ == "__main__":
    main()
