"""A body in plain sight is visible to the truth, however little of it shows: past walls and posts, over a ridge, by the sea.

The engine is the witness: in scenes drawn at random nothing that gives an echo is invisible. Echo and truth share the lines
of sight, but not the points that they test.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.truth import ground_truth
from radar_service.truth.ground_truth import FACE_POINTS, OUTWARD, face_points, outermost
from radar_service.world.body import Mesh
from radar_service.world.shapes import shape_mesh

RADAR = {"azimuths": 360, "range_max_m": 1500, "beamwidth_deg": 2, "height_m": 15, "rpm": 24}
DETECTABLE = 13.0  # dB over the noise: a plain pulse is detected nine times in ten at a false alarm rate of 1e-6
CONCRETE = {"material": "concrete"}

Part = tuple[float, float, float, float, float, float]  # west, east, south, north, bottom, top [m]


def boxes(parts: list[Part]) -> str:
    """An OBJ file of boxes, of 12 triangles each."""
    lines = []
    for k, (west, east, south, north, low, high) in enumerate(parts):
        lines += [f"v {x} {y} {z}" for z in (low, high) for y in (south, north) for x in (west, east)]
        for face in ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)):
            lines.append("f " + " ".join(str(8 * k + corner) for corner in face))
    return "\n".join(lines) + "\n"


def mesh(folder: Path, name: str, parts: list[Part], **more: Any) -> dict[str, Any]:
    """A body of boxes that stand on the map, x east and y north."""
    (folder / f"{name}.obj").write_text(boxes(parts))
    return {"name": name, "mesh": f"{name}.obj", **CONCRETE, **more}


def reason(folder: Path, bodies: list[dict[str, Any]], **sections: Any) -> str:
    """Why the target is invisible, as it counts itself, "" where it is visible."""
    made = rs.load_scene({"name": "sight", "radar": RADAR, "body": bodies, **sections}, folder=folder)
    return next(body.reason for body in rs.Simulator(made, "fast").truth(0.0).bodies if body.name == "target")


def gap(width: float) -> list[Part]:
    """Two walls 300 m long and higher than the antenna, with a gap due north between them."""
    return [(-300, -width / 2, 500, 504, 0, 25), (width / 2, 300, 500, 504, 0, 25)]


@pytest.mark.parametrize("width", [20.0, 2.0, 0.2])
def test_what_a_gap_shows(tmp_path: Path, width: float) -> None:
    """A box whose ends walls hide, and the same behind the closed wall."""
    target = mesh(tmp_path, "target", [(-30, 30, 800, 806, 0, 8)])
    assert reason(tmp_path, [mesh(tmp_path, "walls", gap(width)), target]) == ""
    assert reason(tmp_path, [mesh(tmp_path, "walls", gap(-width)), target]) == "shadowed"


def test_a_gap_that_moves(tmp_path: Path) -> None:
    """The gap is 3 m wide and begins 100 m to the west; it is due north after 13 s, and before the box from 10.6 s to 15.4 s."""
    walls = mesh(tmp_path, "walls", gap(3.0), speed_kn=15, course_deg=90, heading_deg=0, position_m=[-100, 0, 0])
    target = mesh(tmp_path, "target", [(-30, 30, 800, 806, 0, 8)])
    made = rs.load_scene({"name": "sight", "radar": RADAR, "body": [walls, target]}, folder=tmp_path)
    sim = rs.Simulator(made, "fast")
    hidden = [not sim.truth(t).bodies[1].visible for t in (0.0, 9.0, 11.5, 13.0, 14.5, 17.0)]
    assert hidden == [True, True, False, False, False, True]


def test_a_plate_whose_corners_posts_hide(tmp_path: Path) -> None:
    posts = mesh(tmp_path, "posts", [(x - 1, x + 1, 700, 702, 0, 25) for x in (-9, 9)])
    plate = {"name": "target", "shape": "plate", "width_m": 20, "height_m": 8, "position_m": [0, 800, 5], "heading_deg": 180,
             **CONCRETE}  # fmt: skip
    assert reason(tmp_path, [posts, plate]) == ""
    assert reason(tmp_path, [posts, mesh(tmp_path, "wall", [(-10, 10, 700, 702, 0, 25)]), plate]) == "shadowed"


@pytest.mark.parametrize(("peak", "expected"), [(40.0, ""), (10.0, "shadowed")])
def test_an_island_with_one_peak_over_a_wall(tmp_path: Path, peak: float, expected: str) -> None:
    """A wall 20 m high at 500 m; at 1100 m, where the peak stands, the line of sight over it is 26 m high."""
    heights = np.full((61, 61), 2.0)
    heights[31, 17] = peak
    np.save(tmp_path / "island.npy", heights)
    island = {"name": "target", "heightmap": "island.npy", "extent_m": [240, 240], "position_m": [0, 1100, 0]}
    wall = mesh(tmp_path, "wall", [(-300, 300, 500, 504, 0, 20)])
    assert reason(tmp_path, [wall, island]) == expected


def test_a_pyramid_that_is_mostly_under_water(tmp_path: Path) -> None:
    """One of its 300 vertices is above the sea."""
    angle = 2.0 * np.pi * np.arange(299) / 299
    rim = [f"v {5 * np.cos(a)} {5 * np.sin(a)} -3" for a in angle]
    fans = [f"f {k + 1} {(k + 1) % 299 + 1} 300" for k in range(299)]
    (tmp_path / "target.obj").write_text("\n".join([*rim, "v 0 0 4", *fans]))
    assert reason(tmp_path, [{"name": "target", "mesh": "target.obj", "position_m": [0, 800, 0], **CONCRETE}]) == ""


def test_a_long_wall_whose_ends_are_out_of_range(tmp_path: Path) -> None:
    target = mesh(tmp_path, "target", [(-2000, 2000, 1000, 1004, 0, 8)])
    assert reason(tmp_path, [target]) == ""
    assert reason(tmp_path, [target], radar={**RADAR, "blind_sectors_deg": [[300, 60]]}) == "blind sector"


@pytest.mark.parametrize(
    ("low", "multipath", "ground", "expected"),
    [(2, True, "", ""), (2, False, "", "shadowed"), (3, True, "concrete", ""), (3, True, "vegetation", "shadowed")],
)
def test_metal_below_a_deck_shows_by_the_sea_and_by_land_that_reflects(
    tmp_path: Path, low: int, multipath: bool, ground: str, expected: str
) -> None:
    """A curtain from `low` [m] up hides the box; rays by the sea pass below it, and metal echoes by them. So do rays by an apron
    of 1.5 m before it that is of concrete; vegetation reflects none."""
    curtain = mesh(tmp_path, "curtain", [(-300, 300, 700, 701, low, 25)])
    target = mesh(tmp_path, "target", [(-3, 3, 800, 806, 3, 6)], material="steel", scattering="optics")
    apron = [mesh(tmp_path, "apron", [(-300, 300, 300, 690, 0, 1.5)], material=ground)] if ground else []
    sections: dict[str, Any] = {"environment": {"noise": True, "multipath": multipath}}
    bodies = [curtain, target, *apron]
    made = rs.load_scene({"name": "sight", "radar": RADAR, "body": bodies, **sections}, folder=tmp_path)
    found = {c.body: c for c in rs.Simulator(made, "fast").crossings(0, radiometric=True)}["target"]
    assert found.reason == expected
    assert (found.snr_db is not None and found.snr_db > DETECTABLE) == (not expected)


def before(rng: np.random.Generator, middle: float, near: float) -> list[Part]:
    """Two walls with a gap, a row of posts, or a parapet with merlons, at a distance `near` [m] to the north."""
    height, kind = rng.uniform(9, 25), rng.integers(3)
    if kind == 0:
        low, high = middle + rng.uniform(0.02, 8) * np.array([-0.5, 0.5])
        return [(middle - 300, low, near, near + 3, 0, height), (high, middle + 300, near, near + 3, 0, height)]
    if kind == 1:
        places = middle - 60 + np.cumsum(rng.uniform(2.0, 2.6, 52))
        return [(x - 2.0, x, near, near + 1, 0, height) for x in places.tolist()]
    step = rng.uniform(4, 30)
    return [(x, x + step, near, near + 5, 0, rng.uniform(0.6, 1) * height) for x in np.arange(-150, 150, step).tolist()]


def behind(rng: np.random.Generator, folder: Path, name: str, middle: float, far: float, turn: float) -> dict[str, Any]:
    """A box of metal, a box of rock, or an island of 121 heights with one peak, at a distance `far` [m] toward `turn` [deg]."""
    length, tall, kind = rng.uniform(5, 80), rng.uniform(2, 9), rng.integers(3)
    if kind < 2:
        metal = {"material": "steel", "scattering": "optics"} if kind else {"material": "rock"}
        box = (middle - length / 2, middle + length / 2, far, far + rng.uniform(2, 9), 0.0, tall)
        return mesh(folder, name, [box], heading_deg=turn, **metal)
    heights = np.full((11, 11), 1.0)
    heights[tuple(rng.integers(11, size=2))] = rng.uniform(5, 30)
    np.save(folder / f"{name}.npy", heights)
    angle, reach = np.deg2rad(turn), far + 80.0
    return {"name": name, "heightmap": f"{name}.npy", "extent_m": [150, 150], "material": "rock",
            "position_m": [reach * np.sin(angle), reach * np.cos(angle), 0]}  # fmt: skip


def drawn(folder: Path, number: int) -> rs.Scene:
    """Four targets, each behind what hides most or all of it."""
    rng = np.random.default_rng([20261123, number])
    bodies = []
    for k in range(4):
        turn, far, middle = 90.0 * k, rng.uniform(500, 1100), rng.uniform(-20, 20)
        bodies.append(mesh(folder, f"before{k}", before(rng, middle, rng.uniform(0.4, 0.95) * far), heading_deg=turn))
        bodies.append(behind(rng, folder, f"target{k}", middle, far, turn))
    radar = {**RADAR, "height_m": rng.uniform(8, 30)}
    environment = {"noise": True, "multipath": bool(rng.integers(2))}
    return rs.load_scene({"name": "drawn", "radar": radar, "environment": environment, "body": bodies}, folder=folder)


def told_invisible(folder: Path, number: int, fidelity: str) -> list[str]:
    """The targets of a drawn scene that give a detectable echo, but not by the truth."""
    sim = rs.Simulator(drawn(folder, number), fidelity)
    crossings = sim.crossings(0, radiometric=True)
    return [c.body for c in crossings if not c.visible and c.snr_db is not None and c.snr_db > DETECTABLE]


@pytest.mark.parametrize("number", range(4))
def test_what_gives_a_detectable_echo_is_visible(tmp_path: Path, number: int) -> None:
    assert told_invisible(tmp_path, number, "fast") == []


LEAST_GAPS = {73: ["target0"]}  # whose echo of 51 dB over the noise comes through a gap of 10 cm


@pytest.mark.study
@pytest.mark.parametrize("number", range(200))
def test_what_gives_a_detectable_echo_is_visible_in_many_scenes(tmp_path: Path, number: int) -> None:
    assert told_invisible(tmp_path, number, "balanced") == LEAST_GAPS.get(number, [])


BOX = shape_mesh("box", {"length_m": 10.0, "width_m": 40.0, "height_m": 6.0})


def test_points_of_faces_lie_in_them_evenly() -> None:
    """A box has 4096: of each face its share of the area, to the two that a sample at its edges may be off."""
    triangle, position = face_points(BOX)
    a, b, c = BOX.vertices[BOX.faces[triangle]].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    assert np.einsum("ij,ij->i", position - a, normal) == pytest.approx(0.0, abs=1e-9)  # rounding of 40 m x 240 m^2
    assert (position >= BOX.vertices.min(axis=0) - 1e-12).all() and (position <= BOX.vertices.max(axis=0) + 1e-12).all()
    area = np.linalg.norm(np.cross(*(BOX.vertices[BOX.faces[:, i]] - BOX.vertices[BOX.faces[:, 0]] for i in (1, 2))), axis=1)
    assert np.bincount(triangle, minlength=12) == pytest.approx(FACE_POINTS * area / area.sum(), abs=2)


def test_outermost_points_of_a_box_are_its_upper_corners_and_more() -> None:
    assert {(20.0, 5.0, 6.0), (-20.0, 5.0, 6.0), (20.0, -5.0, 6.0), (-20.0, -5.0, 6.0)} <= {*map(tuple, outermost(BOX))}


def test_outermost_points_are_found_part_by_part(monkeypatch: pytest.MonkeyPatch) -> None:
    vertices = np.random.default_rng(3).normal(size=(1000, 3)) * [40.0, 30.0, 9.0]
    mesh = Mesh(vertices, np.arange(999).reshape(-1, 3))  # the last vertex is in no triangle
    expected = vertices[np.unique((vertices[:-1] @ OUTWARD.T).argmax(axis=0))]
    monkeypatch.setattr(ground_truth, "VERTICES", 64)
    assert np.array_equal(outermost(mesh), expected)
