"""The shipped scenes: what their comments promise."""

import io
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import cKDTree

import radar_service as rs
from radar_service.display.video import Controls, display_video, layout
from radar_service.numerics.frames import map_from_body
from radar_service.scattering.physical_optics.model import OpticalBody
from radar_service.world.body import Body
from radar_service.world.poses import pose_at
from tests.reference import make_scenes
from tests.scattering.physical_optics.meshes import cross_section, decibels
from tests.scenes import basin

Floats = NDArray[np.float64]

FOLDER = Path(__file__).parents[1] / "scenes"
NAMES = ["aids", "coast", "far-target", "harbour", "open-sea", "orientation", "worked-example"]


@cache
def scene(name: str) -> rs.Scene:
    return rs.load_scene(basin() if name == "basin" else FOLDER / f"{name}.toml", folder=FOLDER)


def offset(a: Floats, b: Floats | float) -> Floats:
    """How far bearing a lies from b, either way [rad]."""
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi)


def test_every_scene_says_where_it_comes_from_and_is_small() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.toml")) == NAMES
    assert all("# Provenance: " in (FOLDER / f"{name}.toml").read_text() for name in NAMES)
    assert sum(path.stat().st_size for path in FOLDER.iterdir() if path.is_file()) < 3e6  # bytes; required


def test_made_files_come_out_as_committed() -> None:
    for name, made in make_scenes.files().items():
        kept = (FOLDER / name).read_bytes()
        if name.endswith(".png"):  # another zlib packs the same pixels into other bytes
            np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(made))), np.asarray(Image.open(FOLDER / name)))
        else:
            assert made == kept, name


@pytest.mark.parametrize(("bearing_deg", "distance"), [(30, 1000.0), (120, 2000.0), (250, 3000.0)])
def test_orientation_shows_each_target_where_it_belongs(bearing_deg: float, distance: float) -> None:
    simulator, scan = first_scan("orientation")
    rows = offset(scan.azimuth, np.deg2rad(bearing_deg)) < np.deg2rad(20.0)
    window = np.where(rows[:, None], scan.power, 0.0)
    row, column = np.unravel_index(np.argmax(window), window.shape)
    assert abs(scan.range[column] - distance) <= scan.range_step / 2
    # 50 dB above the noise the peak of the beam wanders by less than a spoke (0.5 degrees)
    assert offset(scan.azimuth[row], np.deg2rad(bearing_deg)) < 1.01 * np.deg2rad(0.5)
    assert 45.0 < 10 * np.log10(scan.power.max(where=rows[:, None], initial=0.0) / simulator.noise_power) < 55.0


def test_aids_answer_as_promised() -> None:
    """The SART from the third scan on, by 12 dots where the truth has them, and the racon K of the tower."""
    simulator = rs.Simulator(scene("aids"), "fast", labels=True)
    assert [c.effects["beacon"].triggered for c in simulator.crossings(1) if c.body == "raft"] == [False]
    simulator.skip_to(2)
    scan, beacons = (
        simulator.scan(),
        {c.body: (c.spoke, c.effects["beacon"]) for c in simulator.crossings(2) if "beacon" in c.effects},
    )
    spoke, tower = beacons["light tower"]
    assert scan.labels is not None and tower.letters == "K" and tower.dot is not None
    dashes_and_dot = (tower.begin + np.array([1.5, 4.5, 7.5]) * tower.dot) / scan.range_step
    assert (scan.labels[spoke % len(scan.labels), dashes_and_dot.astype(int)] == 5).all()
    spoke, raft = beacons["raft"]
    assert raft.triggered and raft.first_dot is not None and raft.dot_spacing is not None
    dots = (raft.first_dot + raft.dot_spacing * np.arange(12)) / scan.range_step
    assert (scan.labels[spoke % len(scan.labels), dots.astype(int)] == 6).all()


def test_harbour_is_as_rich_as_promised() -> None:
    harbour = scene("harbour")
    fixed = sum(len(b.mesh.faces) for b in harbour.bodies[:4] if b.mesh is not None)
    under_way = [b for b in harbour.bodies if not b.motion.at_rest]
    assert fixed >= 50_000 and harbour.radar.range_max >= 5000 and harbour.own_ship.at_rest
    assert harbour.radar.scales and not scene("basin").radar.scales  # of a set that is sold
    assert sum(b.scattering == "optics" for b in under_way) >= 2 and all(b.motion.period is not None for b in under_way)


def test_harbour_ships_by_optics_carry_their_fittings() -> None:
    """A smooth hull has some 150 triangles; at rest and under way all have ten times that, but in small files."""
    harbour = scene("harbour")
    ships = {b.name: b.mesh for b in harbour.bodies if b.mmsi is not None and b.scattering == "optics"}
    assert set(ships) == {"moored ship", "tanker at anchor", "ferry", "coaster"}
    assert all(mesh is not None and len(mesh.faces) > 1000 for mesh in ships.values())
    assert all((FOLDER / f"{name}.obj").stat().st_size < 200e3 for name in ("freighter", "tanker", "ferry", "coaster"))
    lengths = {b.name: b.length for b in harbour.bodies}
    assert (lengths["moored ship"], lengths["tanker at anchor"]) == pytest.approx((140.0, 185.0), abs=0.5)  # m


def test_harbour_reflectors_return_what_theory_says() -> None:
    """By optics, from own ship, half a degree off their axes at most: 4 pi a^4 / (3 lambda^2), 27.28 dBsm, to 0.5 dB."""
    harbour = scene("harbour")
    theory = 4.0 * np.pi * 0.6**4 / (3.0 * harbour.radar.wavelength**2)
    reflectors = [b for b in harbour.bodies if b.name.startswith("reflector")]
    assert len(reflectors) == 3 and all(b.rcs is None and b.scattering == "optics" for b in reflectors)
    for body in reflectors:
        antenna = pose_at(body, 0.0).frame_from_map(harbour.antenna(0.0)[0], np.inf)
        result = cross_section(OpticalBody.of(body, harbour.radar, 3), antenna)
        assert decibels(result / theory) == pytest.approx(0.0, abs=0.5), body.name


def sea_floor(positions: Floats) -> Floats:
    """Height of the ground [m] under positions (..., 2 or more), from the generator's formula, not from its picture."""
    return make_scenes.heights(positions[..., 0], positions[..., 1])


def test_harbour_ships_and_buoys_have_water_under_them() -> None:
    for afloat in scene("harbour").bodies:
        if not afloat.name.startswith(("buoy", "ferry", "coaster", "pilot", "moored", "tanker")):
            continue
        times = np.linspace(
            0.0, afloat.motion.period or 0.0, 1000 if afloat.motion.period else 1
        )  # steps of less than half its length
        centre = afloat.motion.pose(times).position
        around = make_scenes.polygon(0.0, 0.0, afloat.length / 2.0)  # the ship turned any way
        assert sea_floor(centre[:, None, :2] + around).max() < 0.0, afloat.name


def outline(solid: Body) -> Floats:
    """Places (n, 2) along all edges of a body at rest, east and north [m], ten metres apart at most."""
    assert solid.mesh is not None
    pose = solid.motion.pose(0.0)
    corners = map_from_body(solid.mesh.vertices, pose.position[0], float(pose.heading[0]))[solid.mesh.faces][..., :2]
    start, end = corners.reshape(-1, 2), np.roll(corners, -1, axis=1).reshape(-1, 2)
    parts = int(np.ceil(np.hypot(*(end - start).T).max() / 10.0))
    return np.concatenate([start + (end - start) * (k / parts) for k in range(parts)])


def test_harbour_ships_under_way_meet_nothing() -> None:
    harbour = scene("harbour")
    solid = cKDTree(
        np.concatenate([outline(b) for b in harbour.bodies if b.name in ("breakwaters", "quays") or is_berthed(b)])
    )
    buoys = cKDTree([b.motion.position[0, :2] for b in harbour.bodies if b.name.startswith("buoy")])
    for ship in (b for b in harbour.bodies if not b.motion.at_rest):
        assert ship.motion.period is not None
        geometry = ship.motion.pose(np.linspace(0.0, ship.motion.period, 3000)).position[:, :2]
        assert np.min(solid.query(geometry)[0]) > ship.length / 2.0 + 10.0, ship.name  # m between ends, turned any way
        assert np.min(buoys.query(geometry)[0]) > ship.beam, ship.name
        assert np.hypot(*geometry.T).min() > 100.0, ship.name  # from own ship


def is_berthed(ship: Body) -> bool:
    return ship.mmsi is not None and ship.motion.at_rest


@cache
def first_scan(name: str) -> tuple[rs.Simulator, rs.Scan]:
    simulator = rs.Simulator(scene(name), "fast")
    return simulator, simulator.scan()


def zeros(name: str, automatic: bool = False, **controls: float) -> float:
    """Share of a scan's video samples that show nothing."""
    simulator, scan = first_scan(name)
    cells = layout(len(scan.range), float(scan.range[0]), scan.range_step)
    chosen = Controls(**controls, gain_auto=automatic, sea_auto=automatic)
    return float(np.mean(display_video(scan.power, cells, chosen, simulator.noise_power) == 0))


def test_video_is_as_sparse_as_before() -> None:
    """At gain 50, where noise shows in 1e-4 of the cells. Half of the last digit, and a point for another draw of the sea.
    Captures of real radars, whose settings are unknown, have 86 to 94 %."""
    shares = zeros("basin", gain=50), zeros("basin", gain=50, sea=100), zeros("open-sea", gain=50)
    print("zero samples: basin {:.1%}, with sea control {:.1%}; open sea {:.1%}".format(*shares))
    assert shares == pytest.approx((0.57, 0.80, 0.85), abs=0.015)
    assert (zeros("harbour", True), zeros("open-sea", True)) == pytest.approx((0.905, 0.998), abs=0.015)


def test_the_hill_of_the_harbour_occludes_bodies_behind_it() -> None:
    _, scan = first_scan("harbour")
    level = np.median(scan.power)
    headland = offset(scan.azimuth, np.deg2rad(275.0)) < np.deg2rad(10.0)
    front = (scan.range > 2800) & (scan.range < 3300)
    behind = (scan.range > 4300) & (scan.range < 4900)  # land, in the lee of a hill of 150 m
    assert scan.power[np.ix_(headland, front)].mean() > 100 * level
    assert scan.power[np.ix_(headland, behind)].mean() < 3 * level  # noise, whose mean is 1.44 times its median


def test_open_sea_ships_pass_as_its_comments_say() -> None:
    simulator = rs.Simulator(scene("open-sea"))
    times = np.arange(0.0, 1801.0, 6.0)  # in 3 s a closing speed of 12 m/s makes 36 m: the margins below are wider
    tracks: dict[str, list[float]] = {}
    for truth in map(simulator.truth, times):
        for seen in truth.bodies:
            tracks.setdefault(seen.name, []).append(seen.range)
    closest = {name: (min(track), float(times[int(np.argmin(track))]) / 60.0) for name, track in tracks.items()}
    assert len(tracks) == 9
    assert closest["tanker"][0] < 150 and 16 < closest["tanker"][1] < 18
    assert 600 < closest["container ship"][0] < 700 and 12 < closest["container ship"][1] < 14
    assert tracks["tanker"][0] == pytest.approx(10_000, rel=0.02) and tracks["container ship"][0] == pytest.approx(
        11_000, rel=0.01
    )


def test_open_sea_shows_every_ship_that_is_in_sight() -> None:
    simulator, scan = first_scan("open-sea")
    for seen in simulator.truth(float(scan.time[len(scan.time) // 2])).bodies:
        rows = offset(scan.azimuth, seen.azimuth) < scan.azimuth[2]
        columns = np.abs(scan.range - seen.range) < 160.0  # half of the longest ship
        peak = scan.power[np.ix_(rows, columns)].max() / simulator.noise_power
        assert peak > 15.0, seen.name  # 11.8 dB: above the display's threshold of 9.6
