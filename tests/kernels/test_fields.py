"""Kernels of legs and of sums on a lattice against numpy; phasors also against exact ones."""

from decimal import Decimal, localcontext

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_body
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.plane_echoes import Wave
from radar_service.scattering.physical_optics.scattering_centres import Lattice
from radar_service.world.poses import BodyPose
from tests.kernels.both import both

EARTH = 4 / 3 * 6_371_000.0
WAVE = Wave(2.0 * np.pi, "h")  # 1 rad/m
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")


def test_phasors_are_exact_up_to_1e8_rad() -> None:
    """Within 4 units in the last place of 1, after the phase is reduced with 60 digits; at 0, quarter turns, and tiny phases."""
    draw = np.random.default_rng(1)
    phase = np.concatenate([draw.uniform(-1e8, 1e8, 2000), draw.uniform(-4.0, 4.0, 2000), np.arange(-9, 10) * np.pi / 4])
    phase = np.append(phase, [0.0, -0.0, 1e-300, 1e-9, 1e8])
    with localcontext(prec=60):
        reduced = np.array([float(Decimal(float(x)) % (2 * PI)) for x in phase])
    compiled, by_numpy = both(lambda: WAVE.phasor(-phase))
    for result in (compiled, by_numpy):
        np.testing.assert_allclose(result, np.cos(reduced) + 1j * np.sin(reduced), rtol=0.0, atol=4 * 2.3e-16)
    assert WAVE.phasor(np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("count", [0, 1, 500])
@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_rays_and_lengths_of_legs(by_sea: bool, earth: float, count: int) -> None:
    """Also at the foot of the antenna, below the sea and beyond the horizon. Positions on the map of 30 km round to 4e-12 m."""
    pose = BodyPose(np.array([300.0, -200.0, 0.5]), 2.1, None)
    antenna = map_from_body(np.array([30.0, 40.0, 20.0]), pose.position, pose.heading)
    leg = BodyLeg(by_sea, pose, antenna, earth)
    points = np.random.default_rng(2).uniform([-100, -100, -2], [100, 100, 40], (500, 3))
    points[:3] = [30.0, 40.0, 3.0], [40_000.0, 0.0, 2.0], [0.0, 0.0, -5.0]
    points = points[:count]
    for one, other in zip(*both(lambda: [leg.eye(point) for point in points]), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(*both(lambda: leg.length(points)), rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("rows", [1, 3])
@pytest.mark.parametrize("count", [0, 2, 60])
def test_sums_on_a_lattice(rows: int, count: int) -> None:
    draw = np.random.default_rng(6)
    lattice = Lattice.over(draw.uniform(-3.0, 3.0, (count, 3)), np.repeat([0.5, 0.8], count // 2), np.inf, -np.inf)
    amplitude = draw.normal(size=count) + 1j * draw.normal(size=count)
    compiled, by_numpy = both(lambda: lattice.sums(amplitude, np.arange(count) % rows, rows))
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=1e-13)
