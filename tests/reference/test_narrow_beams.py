"""The brute force of narrow beams against closed forms, and by two widths of its first cells."""

import numpy as np
import pytest

from radar_service.world.shapes import hull_mesh
from tests.reference.narrow_beams import LIGHT, Floats, profile

WAVELENGTH = LIGHT / 9.41e9
FAR = 3000.0  # m
SIZES = {"pilot": (12.0, 3.0, 4.3), "fishing": (30.0, 6.0, 6.3)}  # length, beam and height [m]


def sheet(corner: Floats, one: Floats, other: Floats) -> Floats:
    """A parallelogram of two triangles."""
    return np.array([[corner, corner + one, corner + one + other], [corner, corner + one + other, corner + other]])


def corner(a: float, sides: int) -> Floats:
    """So many squares between the positive axes."""
    x, y, z = a * np.eye(3)
    origin = np.zeros(3)
    return np.concatenate([sheet(origin, x, z), sheet(origin, z, y), sheet(origin, y, x)][:sides])


def cross_section(mesh: Floats, toward: Floats, width: float, **settings: object) -> float:
    """Of all that a mesh returns together [m^2]."""
    seen = profile(mesh, FAR * toward / np.linalg.norm(toward), width, **settings)  # type: ignore[arg-type]
    return float(np.abs(seen.field[0].sum()) ** 2)


CASES = {
    "plate": (corner(0.6, 1), (0.0, 1.0, 0.0), 4 * np.pi * 0.6**4 / WAVELENGTH**2),
    "dihedral": (corner(0.6, 2), (1.0, 1.0, 0.0), 8 * np.pi * 0.6**4 / WAVELENGTH**2),
    "trihedral": (corner(0.6, 3), (1.0, 1.0, 1.0), 12 * np.pi * 0.6**4 / WAVELENGTH**2),
}


@pytest.mark.parametrize("name", CASES)
def test_plates_and_corners_have_their_closed_forms(name: str) -> None:
    """At 3 km the phase over 0.6 m bends by k 0.3^2 / R = 0.006 rad; single surfaces of the dihedral add or take 0.04 dB."""
    mesh, toward, theory = CASES[name]
    for polarization in "hv":
        seen = cross_section(mesh, np.array(toward), 0.05, polarization=polarization)
        assert 10 * np.log10(seen / theory) == pytest.approx(0.0, abs=0.08)


@pytest.mark.parametrize("polarization", "hv")
def test_a_plate_over_the_sea_returns_by_all_four_ways(polarization: str) -> None:
    """By the sea both ways it is what its image sees. One way it stands square on the sea, a corner: twice its whole surface, as
    the phase along its height turns by k h (e' - e)."""
    plate, antenna, image = corner(0.6, 1) + (0.0, 0.0, 3.0), np.array([0.3, 500.0, 15.0]), np.array([0.3, 500.0, -15.0])
    seen = profile(plate, antenna, 0.006, polarization=polarization, water=0.0).field.sum(axis=1)
    below = profile(plate, image, 0.006, polarization=polarization).field[0].sum()
    turn = 0.6 * ((15.0 + 3.3) - (15.0 - 3.3)) / 500.0 / WAVELENGTH
    assert abs(seen[2] - below) < 0.005 * abs(below)
    assert abs(seen[1]) == pytest.approx(2.0 * 2.0 * np.sqrt(np.pi) * 0.36 / WAVELENGTH * np.sinc(turn), rel=0.005)


def test_what_lies_behind_or_below_the_water_returns_nothing() -> None:
    """A plate 1 m behind another, and one that is half under water: its dry half returns a quarter of the power."""
    plate, toward = corner(0.6, 1), np.array([0.3, FAR, 0.3])
    alone, both = (
        profile(mesh, toward, 0.006).field[0].sum() for mesh in (plate, np.concatenate([plate, plate - (0, 1, 0)]))
    )
    half = profile(plate, toward, 0.006, water=0.3).field[0].sum()
    assert abs(both - alone) < 1e-3 * abs(alone)
    assert abs(half) == pytest.approx(abs(alone) / 2.0, rel=0.01)


@pytest.mark.study
@pytest.mark.parametrize("kind", ["pilot"])
@pytest.mark.parametrize("azimuth_deg", [37.0, 95.0])
def test_ships_converge_with_the_width_of_cells(kind: str, azimuth_deg: float) -> None:
    """Range cells of 7.5 m, without the sea, where no cell is small by cancelling: first cells of 60 mm against others placed
    anew, and against half as wide ones."""
    mesh = hull_mesh(kind, 1, *SIZES[kind])
    az = np.deg2rad(azimuth_deg)
    antenna = np.array([800.0 * np.sin(az), 800.0 * np.cos(az), 15.0])
    cells = [
        profile(mesh.vertices[mesh.faces], antenna, width, seed=seed).cells(7.5, 1.875, 750.0, 60)
        for width, seed in ((0.06, 1), (0.06, 2), (0.03, 3))
    ]
    largest = np.abs(cells[-1]).max()
    assert np.abs(cells[0] - cells[1]).max() < 0.03 * largest
    assert np.abs(cells[0] - cells[2]).max() < 0.03 * largest
