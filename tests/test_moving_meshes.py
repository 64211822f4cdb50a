"""Meshes in motion against a slow reference: every scatterer at every azimuth in float64, by closed form."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import fidelity_from_name
from tests.reference.compressed_pulse import point_field, sinc2_beam
from tests.scenes import point, scene

RADAR = {"range_max_m": 500, "azimuths": 90, "beamwidth_deg": 12, "pulse_s": 1e-6}
EARTH = 4 / 3 * 6_371_000.0
Array = np.ndarray[Any, Any]


def map_from_headings(points: Array, heading: Array) -> Array:
    """Points (E, 3) turned by headings (K,) to (K, E, 3): the bow (y) goes to the heading, clockwise from north."""
    c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
    x, y = points[:, 0], points[:, 1]
    return np.stack([x * c + y * s, y * c - x * s, np.broadcast_to(points[:, 2], (len(heading), len(points)))], axis=-1)


def reference_field(made: rs.Scene, engine: Engine, scan: int) -> Array:
    """The field of the echoes in each visibility snapshot of the engine, every azimuth at its own instant."""
    radar, visibility = made.radar, engine.prepared.moving.visibility
    rows, every = [], np.arange(radar.azimuths)
    steps = ((scan * radar.azimuths + every) * radar.spoke_period // visibility.interval).astype(int)
    for step in np.unique(steps):
        index = every[steps == step]
        number = scan * radar.azimuths + index
        time = number * radar.spoke_period
        echoes = engine.prepared.moving.snapshot(int(step)).echoes
        position = np.empty((len(time), len(echoes), 3))
        for b, body in enumerate(visibility.scatterers.bodies):
            own, pose = echoes.body == b, body.motion.pose(time)
            position[:, own] = map_from_headings(echoes.position[own], pose.heading) + pose.position[:, None]
        position -= made.own_ship.pose(time).position[:, None] + np.array([0, 0, radar.height])
        d2 = position[..., 0] ** 2 + position[..., 1] ** 2
        z = position[..., 2] - d2 / (2 * EARTH)
        r = np.sqrt(d2 + z**2)
        level = np.sqrt(radar.power * radar.wavelength**2 / (4 * np.pi) ** 3) * radar.gain / r**2
        level = level * sinc2_beam(np.arctan2(z, np.sqrt(d2)), radar.beamwidth_el) * echoes.amplitude
        azimuth = np.arctan2(position[..., 0], position[..., 1])
        boresight = (number % radar.azimuths) * 2 * np.pi / radar.azimuths
        rows.append(point_field(engine.range, boresight, r, azimuth, level, radar.wavelength, radar.bandwidth, radar.pulse,
                                (0.54, 0.46), radar.beamwidth))  # fmt: skip
    return np.concatenate(rows)


def engine_for(made: rs.Scene) -> Engine:
    return Engine(prepare(made, fidelity_from_name("balanced"), 3))


def whole_scan(engine: Engine, scan: int) -> Array:
    """The field of one scan."""
    return np.concatenate([field for _, field, _ in engine.tiles(scan)])


def hull(name: str, east: float, north: float, **more: Any) -> dict[str, Any]:
    size = {"shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6, "material": "wood", "scattering": "diffuse"}
    return {"name": name, "position_m": [east, north, 0], **size, **more}


def error_db(got: Array, exact: Array) -> float:
    return float(10 * np.log10(np.sum(np.abs(got - exact) ** 2) / np.sum(np.abs(exact) ** 2)))


@pytest.mark.sample(3)
@pytest.mark.parametrize("knots", [0.1, 1.0, 12.0, 40.0])
@pytest.mark.parametrize("moving", ["own ship", "bodies"])
def test_moving_meshes_equal_the_reference_at_every_azimuth(knots: float, moving: str) -> None:
    """-40 dB (required); ours -51.8 at 40 kn, -58 and better else: moving echoes cover the full circle, so the series alone
    errs."""
    geometry = {"speed_kn": knots, "course_deg": 60}
    bodies = [hull("a", 150, 160), hull("b", -60, -250), hull("c", -330, 120)]
    bodies = [{**body, **(geometry if moving == "bodies" else {"heading_deg": 60})} for body in bodies]
    made = scene(bodies, radar=RADAR, own_ship=geometry if moving == "own ship" else {})
    engine = engine_for(made)
    assert error_db(whole_scan(engine, 1), reference_field(made, engine, 1)) < -50


def test_points_that_pass_close_by_are_exact() -> None:
    """Points 6 to 40 m off as own ship passes them at 40 kn, where a parabola over 16 azimuths errs by metres:
    -50 dB as anywhere. Their aspect runs through a right angle while the beam passes."""
    rng = np.random.default_rng(6)
    spots = [point(f"p{k}", rng.uniform(6, 40) * rng.choice([-1, 1]), rng.uniform(0, 60), 12, -60) for k in range(12)]
    made = scene(spots, radar=RADAR, own_ship={"speed_kn": 40, "course_deg": 0})
    engine = engine_for(made)
    assert error_db(whole_scan(engine, 0), reference_field(made, engine, 0)) < -50


def test_a_turning_mesh_equals_the_reference() -> None:
    """40 m of hull turning at 6 degrees a second on an arc that begins and ends within the scan: bow and stern go 2 m/s
    apart, and corners of the track fall between azimuths."""
    corners = [{"position_m": list(p), "speed_kn": 12} for p in [(190, 230), (320, 230)]]
    made = scene([hull("a", 190, 160, waypoints=corners, turn_radius_m=55)], radar=RADAR)
    engine = engine_for(made)
    for number in range(5):
        assert error_db(whole_scan(engine, number), reference_field(made, engine, number)) < -50
