"""From a scene file over the real service to the Python client and its picture: things stand where the scene puts them."""

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

import radar_service as rs
import scenes
from clients.ppi import spokes
from clients.ppi.__main__ import main as receive

Serve = Callable[..., str]
TARGETS = {"orientation": [(30.0, 1000.0), (120.0, 2000.0), (250.0, 3000.0)], "worked-example": [(45.0, 200.0)]}
SIZE = 600


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Serve]:
    """Puts a scene text on the air, as fast as the machine goes if nothing else is given, and gives the address."""
    services = []

    def start(text: str, *options: str, pace: str = "max") -> str:
        (path := tmp_path / "scene.toml").write_text(text)
        command = [sys.executable, "-m", "radar_service", "serve", str(path), "--port", "0", "--pace", pace, *options]
        services.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
        assert services[-1].stdout is not None
        return services[-1].stdout.readline().split("open http://")[1].strip().rstrip("/")

    yield start
    for service in services:
        service.terminate()
        service.communicate(timeout=60)


def disc(picture: NDArray[np.float64]) -> float:
    """Radius of the scope in pixels: the median, over bearings without labels, of where the page's black begins."""
    ends = []
    for bearing in np.deg2rad(np.arange(5, 360, 30) + 7):
        along = np.arange(SIZE / 4, SIZE / 2 - 1, 0.5)
        x = np.rint(SIZE / 2 + along * np.sin(bearing)).astype(int)
        y = np.rint(SIZE / 2 - along * np.cos(bearing)).astype(int)
        ends.append(along[picture[y, x].max(axis=1) > 0].max())
    return float(np.median(ends))


def spots(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centroids (n, 2), pixels right of and above the centre, of what is nearly as bright as the strongest echo."""
    coloured = picture.max(axis=2) - picture.min(axis=2) > 60  # rings, labels and the heading line are grey
    inside = np.hypot(*(np.indices(picture.shape[:2]) - (SIZE - 1) / 2)) < disc(picture) - 3
    brightness = picture.sum(axis=2) * (coloured & inside)
    strong = brightness > 0.8 * brightness.max()
    labels, count = ndimage.label(ndimage.binary_dilation(strong, iterations=2))
    centres = np.array(ndimage.center_of_mass(strong, labels, range(1, count + 1)))
    return np.stack([centres[:, 1] - (SIZE - 1) / 2, (SIZE - 1) / 2 - centres[:, 0]], axis=1)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", ["orientation", "worked-example"])
@pytest.mark.parametrize("heading_deg", [0, 70])
def test_targets_stand_where_the_scene_puts_them(name: str, heading_deg: int, serve: Serve, tmp_path: Path) -> None:
    """In the feed: the strongest cell is the one that holds the target (half a bin, half a spoke). In the client's picture:
    the spot lies within 2 pixels and 1.5 % of the radius of its position (rings and disc edges are whole pixels)."""
    text = (Path(scenes.__file__).parent / f"{name}.toml").read_text()
    text = (
        re.sub(r"\[own_ship\]\nheading_deg = 0\n|noise = true\n", "", text) + f"\n[own_ship]\nheading_deg = {heading_deg}\n"
    )
    address = serve(text, pace="20")  # a scan in an eighth of a second, and a core that is free for the picture
    out, arrays = tmp_path / "ppi.png", tmp_path / "scan.npz"
    common = [f"ws://{address}", "--mode", "lossless", "--overwrite", "--npz", str(arrays), "--out", str(out)]
    common += ["--size", str(SIZE), "--encoding", "f32"]
    for up in ([], ["--head-up"]) if heading_deg else ([],):
        assert receive([*common, *up]) == 0
        with np.load(arrays) as file:
            power, azimuth, distance, step = file["power"][0], file["azimuth"], file["range"], float(file["range_step"])
            np.testing.assert_allclose(file["heading"][0], np.deg2rad(heading_deg), atol=2 * np.pi / 65536)
        expected = []
        for bearing_deg, reach in TARGETS[name]:
            near = np.flatnonzero(np.abs(distance - reach) < 60)
            k, n = np.unravel_index(np.argmax(power[:, near]), (len(power), len(near)))
            assert abs(np.rad2deg(azimuth[k]) - bearing_deg) <= 0.25
            assert abs(distance[near[n]] - reach) <= step / 2 + 1e-3
            turned = np.deg2rad(bearing_deg - (heading_deg if up else 0))
            expected.append(reach * np.array([np.sin(turned), np.cos(turned)]) / (len(distance) * step))
        picture = np.asarray(Image.open(out).convert("RGB")).astype(np.float64)
        located = spots(picture) / disc(picture)
        assert len(located) == len(expected)
        for spot in expected:
            assert np.hypot(*(located - spot).T).min() < 0.015 + 2 / disc(picture)


MOVING = """
[radar]
azimuths = 90
beamwidth_deg = 6
range_max_m = 1500
[environment]
noise = true
[[body]]
name = "p"
shape = "point"
position_m = [300, 600, 5]
rcs_dbsm = 20
swerling = 1
course_deg = 200
speed_kn = 20
"""


ERRORS = """
[own_ship]
heading_deg = 40
[errors]
profile = "imo-a823"
[errors.gyro]
latency_s = 0.5
[errors.feed]
drop_rate = 0.1
repeat_rate = 0.1
late_rate = 0.1
swap_rate = 0.1
stuck_sector_deg = [40, 80]
heading_lost_s = [[1, 2]]
"""


def test_a_client_of_the_service_meets_the_errors_of_a_simulator(serve: Serve, tmp_path: Path) -> None:
    """Spoke by spoke, from number 0: order, echoes to the byte, and what is reported to the half of a part of the wire."""
    address = serve(MOVING + ERRORS, "--wait-for", "1", "--seed", "6")
    sim = rs.Simulator(rs.load_scene(tmp_path / "scene.toml"), seed=6)
    expected = list(sim.feed(4))
    received = list(islice(spokes(f"ws://{address}", mode="lossless", encoding="f32", timeout=30.0), len(expected)))
    assert [spoke.number for spoke in received] == list(range(len(expected)))
    assert [90 * spoke.scan + spoke.index for spoke in received] == [spoke.number for spoke in expected]
    assert len(expected) != 4 * 90 and any(np.isnan(spoke.heading) for spoke in expected)
    half = 0.5 * 2.0 * np.pi / 65536 * (1 + 1e-9)
    for one, other in zip(received, expected, strict=True):
        assert one.samples.tobytes() == other.power.tobytes()
        assert (one.time, one.position, one.speed) == (other.time, other.position, other.speed)
        for name in ("azimuth", "heading", "course"):
            error = getattr(one, name) - getattr(other, name)
            assert abs((error + np.pi) % (2 * np.pi) - np.pi) <= half or np.isnan(getattr(other, name))
            assert np.isnan(getattr(one, name)) == np.isnan(getattr(other, name))
