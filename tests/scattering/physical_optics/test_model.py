"""Physical optics as a scattering model: bistatic plates by closed form, and results kept from crossing to crossing."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.fidelity import PRESETS
from radar_service.frames import map_from_body
from radar_service.scattering.beam_crossing import BeamCrossing
from radar_service.scattering.model import BodyEchoes, Instant, ScatteringContext, Sector
from radar_service.scattering.physical_optics.model import PhysicalOptics, antenna_in_body_frame
from radar_service.scene.poses import pose_at
from radar_service.trace.embree import RayCount
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scattering.physical_optics.meshes import WAVELENGTH, decibels
from tests.scenes import scene

K = 2 * np.pi / WAVELENGTH
CENTRE = np.array([0.0, 5000.0, 15.0])
PLATE = {"name": "p", "shape": "plate", "width_m": 0.5, "height_m": 0.3, "position_m": [0, 5000, 15], "heading_deg": 180,
         "scattering": "optics"}  # fmt: skip
CORNER = {"name": "c", "shape": "trihedral", "edge_m": 0.5, "position_m": [0, 900, 15], "heading_deg": 180,
          "scattering": "optics"}  # fmt: skip
FLAT = {"earth": "flat"}


def build(made: rs.Scene, crossing: BeamCrossing | None = None) -> PhysicalOptics:
    context = ScatteringContext(made.radar, PRESETS["balanced"], 3, made.antenna(0.0)[0], made.bodies, np.inf, crossing)
    return PhysicalOptics.build(made.bodies, np.arange(len(made.bodies)), context)


def instant(made: rs.Scene, time: float = 0.0, rays: RayCount | None = None, **more: Any) -> Instant:
    return Instant(time, OcclusionScene(made.bodies, np.inf, rays=rays), 1e5, **more)


def field(made: rs.Scene, echoes: BodyEchoes, launch: np.ndarray, receive: np.ndarray) -> complex:
    """Sum of echoes of the first body [m] with the phase of their paths."""
    pose = pose_at(made.bodies[0], 0.0)
    position = map_from_body(echoes.position, pose.position, pose.heading)
    path = np.linalg.norm(position - launch, axis=1) + np.linalg.norm(position - receive, axis=1)
    return complex(np.sum(echoes.amplitude * np.exp(-1j * K * path)))


def toward(angle_deg: float) -> np.ndarray:
    """4 km from the plate, level with it, at an angle from its normal to the west."""
    a = np.deg2rad(angle_deg)
    return CENTRE - 4000.0 * np.array([np.sin(a), np.cos(a), 0.0])


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize(
    ("incident", "scattered"), [(0, 0), (20, -20), (20, -21.5), (35, -30), (50, -49), (10, 5), (-3, 60)]
)
def test_a_bistatic_plate_follows_the_closed_form(polarization: str, incident: float, scattered: float) -> None:
    """4 pi A^2 / lambda^2 sinc^2(k a (sin i + sin s) / 2) times cos^2 i where the field is along the plate's edge, v, and
    cos^2 s where it lies in the plane of both directions, h (Balanis 2012, section 11.3). 4 km is 250 times the far field of
    0.5 m; path errors of k a^2 / 8 R are 1.5 mrad. Off the main lobe -20 dB of its peak err by 0.3 dB at most: 1 % of it."""
    made = scene([PLATE], radar={"polarization": polarization}, environment=FLAT)
    launch, receive = toward(incident), toward(scattered)
    i, s = np.deg2rad([incident, scattered])
    peak = 4 * np.pi * 0.15**2 / WAVELENGTH**2
    obliquity = np.cos(i) if polarization == "v" else np.cos(s)
    expected = np.sqrt(peak) * obliquity * np.sinc(0.5 * (np.sin(i) + np.sin(s)) / WAVELENGTH)
    result = field(made, build(made).echoes(launch, receive, instant(made)), launch, receive)
    assert abs(result) == pytest.approx(abs(expected), abs=0.01 * np.sqrt(peak))


@pytest.mark.parametrize("angles", [(20.0, -21.0), (0.0, 1.0)])
def test_bistatic_echoes_are_reciprocal(angles: tuple[float, float]) -> None:
    """v: obliquities of both ends differ by physical optics' own error, cos i against cos s, 0.7 % at 20 degrees."""
    made = scene([PLATE], radar={"polarization": "v"}, environment=FLAT)
    one, other = toward(angles[0]), toward(angles[1])
    there, back = (field(made, build(made).echoes(a, b, instant(made)), a, b) for a, b in ((one, other), (other, one)))
    ratio = np.cos(np.deg2rad(angles[0])) / np.cos(np.deg2rad(angles[1]))
    assert there / back == pytest.approx(ratio, rel=1e-4)


@pytest.mark.parametrize("body", [PLATE, CORNER], ids=["plate", "corner"])
def test_two_ends_at_one_position_are_one_antenna(body: dict[str, Any]) -> None:
    """A copy of the position is computed as two ends: phase centres of a corner move, the field stays, but for the faintest
    centres, -50 dB."""
    made = scene([{**body, "heading_deg": 180 if body is PLATE else 0}], environment=FLAT)
    antenna = made.antenna(0.0)[0] if body is PLATE else np.array([350.0, 1600.0, 300.0])
    one, two = (build(made).echoes(antenna, receive, instant(made)) for receive in (antenna, antenna.copy()))
    fields = [field(made, echoes, antenna, antenna) for echoes in (one, two)]
    assert abs(fields[0]) > 0 and abs(fields[1] / fields[0] - 1) < 2 * 10 ** (-50 / 20)


def test_a_corner_returns_little_to_another_position() -> None:
    """Trihedral echoes go back where they came from: 10 degrees aside they are 15 dB lower."""
    made = scene([CORNER], environment=FLAT)
    launch = made.antenna(0.0)[0]
    aside = launch + np.array([900 * np.tan(np.deg2rad(10)), 0.0, 0.0])
    model = build(made)
    levels = [abs(np.sum(model.echoes(launch, end, instant(made)).amplitude)) for end in (launch, aside)]
    fields = [abs(field(made, model.echoes(launch, end, instant(made)), launch, end)) ** 2 for end in (launch, aside)]
    assert levels[0] > 0 and decibels(fields[1] / fields[0]) < -15


def test_results_last_for_a_crossing_and_until_they_are_cleared() -> None:
    """At rest in a moving set: a second instant of the same crossing casts no ray; the next crossing and `clear` do."""
    made = scene([{**CORNER, "course_deg": 90, "speed_kn": 5}], environment=FLAT)
    model, rays = build(made, BeamCrossing(made)), RayCount()
    line_of_sight = OcclusionScene(made.bodies, np.inf, rays=rays)
    period = made.radar.rotation_period

    def cast(time: float) -> int:
        before, antenna = rays.rays, made.antenna(time)[0]
        model.echoes(antenna, Instant(time, line_of_sight, 1e5))
        return rays.rays - before

    assert cast(3 * period - 0.2) > 0 and cast(3 * period + 0.3) == 0
    assert cast(4 * period) > 0 and cast(3 * period) == 0
    model.clear()
    assert cast(3 * period) > 0


def test_bodies_beside_a_sector_are_not_evaluated() -> None:
    bodies = [{**CORNER, "name": str(k), "position_m": [900 * np.sin(k), 900 * np.cos(k), 15]} for k in (0, 1, 3)]
    made = scene([{**body, "heading_deg": 180 + np.rad2deg(k)} for body, k in zip(bodies, (0, 1, 3), strict=True)])
    antenna = made.antenna(0.0)[0]
    model = build(made)
    assert set(model.echoes(antenna, instant(made)).body.tolist()) == {0, 1, 2}
    sector = Sector(antenna, 1.0, 0.2, 1.0)
    assert set(model.echoes(antenna, instant(made, sector=sector)).body.tolist()) == {1}


def test_the_antenna_in_the_frame_of_a_body_keeps_the_range() -> None:
    """Over the curved earth, turned: 12 km off the drop is 8.5 m; the range is that of the antenna's frame to 1 mm."""
    made = scene([{**CORNER, "position_m": [7200, 9600, 5], "heading_deg": 33}])
    body, antenna = made.bodies[0], np.array([0.0, 0.0, 15.0])
    earth = 4 / 3 * 6_371_000.0
    local = antenna_in_body_frame(body, pose_at(body, 0.0), antenna, earth)
    drop = 12_000.0**2 / (2 * earth)
    assert np.linalg.norm(local) == pytest.approx(np.hypot(12_000.0, 5 - 15 - drop), abs=1e-3)
    assert np.arctan2(local[0], local[1]) == pytest.approx(np.arctan2(-7200, -9600) - np.deg2rad(33), abs=1e-3)


def test_the_stated_maximum_holds_at_every_aspect() -> None:
    made = scene([CORNER], environment=FLAT)
    limit = PhysicalOptics.max_rcs(made.bodies[0], made.radar, PRESETS["balanced"])
    model = build(made)
    for turn in np.linspace(0, 2 * np.pi, 19):
        antenna = np.array([2000 * np.sin(turn), 900 + 2000 * np.cos(turn), 500.0])
        power = abs(field(made, model.echoes(antenna, instant(made)), antenna, antenna)) ** 2
        assert power < limit
    once = PhysicalOptics.max_rcs(made.bodies[0], made.radar, replace(PRESETS["balanced"], bounces=1))
    assert limit == pytest.approx(9 * once)
