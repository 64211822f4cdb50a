"""Physical optics as a scattering model: bodies over the sea, in the water and in shadow, element by element."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import i0e

import radar_service as rs
from radar_service.numerics.frames import map_from_body, polar_from_map
from radar_service.propagation.multipath import reflected_field_ratio, specular_geometry
from radar_service.propagation.radar_equation import elevation_gain
from radar_service.propagation.sea_surface import miller_brown, rms_wave_height
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BearingWedge, BodyEchoes
from radar_service.scattering.physical_optics.model import PhysicalOptics, optical_bodies
from radar_service.world.poses import pose_at
from tests.scattering.physical_optics.meshes import WAVELENGTH, decibels
from tests.scattering.test_fixed_scatterers import build, instant
from tests.scenes import scene

K = 2 * np.pi / WAVELENGTH
PLATE = {"name": "p", "shape": "plate", "width_m": 0.5, "height_m": 0.3, "position_m": [0, 5000, 15], "heading_deg": 180,
         "scattering": "optics"}  # fmt: skip
CORNER = {"name": "c", "shape": "trihedral", "edge_m": 0.5, "position_m": [0, 900, 15], "heading_deg": 180,
          "scattering": "optics"}  # fmt: skip
FLAT = {"earth": "flat"}  # over the sea where multipath is added


def field(made: rs.Scene, echoes: BodyEchoes, antenna: np.ndarray) -> complex:
    """Sum of echoes of the first body [m] with the phase of their paths."""
    pose = pose_at(made.bodies[0], 0.0)
    position = map_from_body(echoes.position, pose.position, pose.heading)
    return complex(np.sum(echoes.amplitude * np.exp(-2j * K * np.linalg.norm(position - antenna, axis=1))))


def section_over_the_sea(made: rs.Scene, earth: float, state: int) -> float:
    """|sum of echoes|^2 [m^2] of all paths of the first body, at its own range."""
    antenna = made.antenna(0.0)[0]
    echoes = build(PhysicalOptics, made, earth=earth).body_echoes(0, antenna, instant(made, earth=earth))
    pose = pose_at(made.bodies[0], 0.0)
    position = map_from_body(echoes.position, pose.position, pose.heading)
    polar = polar_from_map(position, antenna, earth)
    geometry = specular_geometry(polar.distance, position[:, 2], float(antenna[2]), earth)
    ratio = reflected_field_ratio(geometry, WAVELENGTH, made.radar.polarization, rms_wave_height(state), miller_brown)
    gains = [elevation_gain(made.radar, angle) for angle in (geometry.elevation_reflected, geometry.elevation_direct)]
    ratio = ratio * np.exp(-1j * K * geometry.excess) * np.sqrt(gains[0] / gains[1])
    gain = elevation_gain(made.radar, polar.elevation) * (np.linalg.norm(pose.position - antenna) / polar.range) ** 2
    return float(abs(np.sum(echoes.amplitude * gain * ratio**echoes.path * np.exp(-2j * K * polar.range))) ** 2)


def elements_over_the_sea(width: float, height: float, distance: float, radar: rs.Scene, state: int) -> float:
    """The same of an upright plate that stands on a flat sea, square to the north: elements of 4 mm, each of them with the
    square of its own two-ray factor, near enough to grazing for one obliquity (2 %)."""
    antenna_height = radar.radar.height
    x = (np.arange(round(width / 0.01)) + 0.5) * 0.01 - width / 2
    z = (np.arange(round(height / 0.004)) + 0.5) * 0.004
    direct = np.sqrt(x[:, None] ** 2 + distance**2 + (z - antenna_height) ** 2)
    by_sea = np.sqrt(x[:, None] ** 2 + distance**2 + (z + antenna_height) ** 2)
    grazing = np.arctan2(z + antenna_height, distance)
    sine, permittivity = np.sin(grazing), 55.3 - 38.2j
    root = np.sqrt(permittivity - np.cos(grazing) ** 2)
    first = sine if radar.radar.polarization == "h" else permittivity * sine
    half = 0.5 * (2 * K * rms_wave_height(state) * sine) ** 2
    surface = (first - root) / (first + root) * i0e(half)

    def pattern(angle: np.ndarray) -> np.ndarray:
        return np.abs(np.sinc(2.783114752 / np.pi * angle / radar.radar.beamwidth_el))

    out = pattern(np.arctan2(z - antenna_height, distance)) * np.exp(-1j * K * direct) / direct
    back = surface * pattern(grazing) * np.exp(-1j * K * by_sea) / by_sea
    total = np.sum((out + back) ** 2) * 0.01 * 0.004 * (distance**2 + antenna_height**2)
    return float(4 * np.pi / WAVELENGTH**2 * abs(total) ** 2)


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("state", [0, 3])
@pytest.mark.parametrize(("height", "distance"), [(7.0, 450.0), (7.0, 3700.0), (3.0, 150.0), (2.0, 1000.0)])
def test_metal_on_the_water_is_the_sum_of_its_elements(
    polarization: str, state: int, height: float, distance: float
) -> None:
    """Mast of 0.25 m: 0.1 dB, mostly the obliquity that elements leave out at 150 m (0.1 rad: 0.5 %, twice).
    One centre with F^2 errs by 23 dB."""
    mast = {"name": "m", "shape": "plate", "width_m": 0.25, "height_m": height, "scattering": "optics",
            "position_m": [0, distance, height / 2], "heading_deg": 180}  # fmt: skip
    made = scene([mast], radar={"polarization": polarization}, environment={**FLAT, "multipath": True, "sea_state": state})
    theory = elements_over_the_sea(0.25, height, distance, made, state)
    assert decibels(section_over_the_sea(made, np.inf, state) / theory) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("rises", [0.4, 0.8, 1.3])
def test_a_plate_in_the_water_is_the_plate_that_ends_there(rises: float) -> None:
    """4 m high, mostly below the surface: the same sections as of a plate of what rises above it, to rounding of the cuts."""
    plates = [(4.0, rises - 2.0), (rises, rises / 2)]
    sections = [
        section_over_the_sea(
            scene([{**PLATE, "width_m": 1.5, "height_m": height, "position_m": [30, 800, up], "heading_deg": 178}],
                  environment={**FLAT, "multipath": True}), np.inf, 0)
        for height, up in plates
    ]  # fmt: skip
    assert decibels(sections[0] / sections[1]) == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize(("hidden", "loss"), [(0.25, -2.5), (0.6, -7.9), (0.8, -14.0)])
def test_a_plate_partly_hidden_loses_what_is_hidden(hidden: float, loss: float) -> None:
    """1.7 m, shorter than c/2B, behind a wall half way: 20 log of the visible share, geometric shadow; 0.1 dB of rounding and
    of the bend over the plate."""
    plate = {**PLATE, "width_m": 1.7, "height_m": 1.7, "position_m": [0, 1000, 15], "name": "plate"}
    wall = {"name": "w", "shape": "box", "length_m": 1, "width_m": 60, "height_m": 40, "rcs_dbsm": -100}
    edge = 30.0 + 1.7 * (0.5 - hidden) / 2  # half way the plate is half as wide
    sections = []
    for bodies in ([plate], [plate, {**wall, "position_m": [edge, 500.5, 0]}]):
        made = scene(bodies, environment={**FLAT, "multipath": False})
        antenna = made.antenna(0.0)[0]
        sections.append(abs(field(made, build(PhysicalOptics, made).body_echoes(0, antenna, instant(made)), antenna)) ** 2)
    assert decibels(sections[1] / sections[0]) == pytest.approx(loss, abs=0.15)


def test_bodies_beside_a_sector_are_not_evaluated() -> None:
    bodies = [{**CORNER, "name": str(k), "position_m": [900 * np.sin(k), 900 * np.cos(k), 15]} for k in (0, 1, 3)]
    made = scene([{**body, "heading_deg": 180 + np.rad2deg(k)} for body, k in zip(bodies, (0, 1, 3), strict=True)])
    antenna = made.antenna(0.0)[0]
    model = build(PhysicalOptics, made)
    assert set(model.echoes(antenna, instant(made)).body.tolist()) == {0, 1, 2}
    sector = BearingWedge(antenna, 1.0, 0.2, 1.0)
    assert set(model.echoes(antenna, instant(made, wedge=sector)).body.tolist()) == {1}


def test_the_stated_maximum_holds_at_every_aspect() -> None:
    made = scene([CORNER], environment=FLAT)
    limit = PhysicalOptics.max_rcs(made.bodies[0], made.radar, PRESETS["balanced"])
    model = build(PhysicalOptics, made)
    for turn in np.linspace(0, 2 * np.pi, 19):
        antenna = np.array([2000 * np.sin(turn), 900 + 2000 * np.cos(turn), 500.0])
        power = abs(field(made, model.echoes(antenna, instant(made)), antenna)) ** 2
        assert power < limit
    once = PhysicalOptics.max_rcs(made.bodies[0], made.radar, replace(PRESETS["balanced"], bounces=1))
    assert limit == pytest.approx(9 * once)


BOX = {"shape": "box", "length_m": 10, "width_m": 4, "height_m": 3, "position_m": [0, 500, 0], "material": "steel"}


def bodies(*changes: dict[str, object]) -> rs.Scene:
    return scene([{**BOX, "name": f"b{k}", **change} for k, change in enumerate(changes)])


def test_equal_boxes_are_one_wherever_they_are_and_others_are_not() -> None:
    made = bodies({}, {"position_m": [900, 0, 0], "speed_kn": 9}, {"length_m": 11}, {"material": "aluminium"})
    optical = optical_bodies(made.bodies, made.radar, 3)
    assert optical[0] is optical[1]
    assert len({id(one) for one in optical}) == 3


def test_a_box_among_equal_ones_echoes_as_alone() -> None:
    """A field is the sum of the fields of its bodies; rounding of float32 sums, 1e-5 of the peak."""
    sections = {"radar": {"range_max_m": 1500, "azimuths": 90, "beamwidth_deg": 8}, "environment": {"noise": False}}
    given = [{**BOX, "name": "a", "speed_kn": 5}, {**BOX, "name": "b", "position_m": [300, -900, 0], "speed_kn": 5}]

    def field(*which: int) -> np.ndarray:
        return np.asarray(rs.Simulator(scene([given[k] for k in which], **sections), "fast").scan().field)

    both, alone = field(0, 1), field(0) + field(1)
    np.testing.assert_allclose(both, alone, rtol=0, atol=1e-5 * np.abs(both).max())
