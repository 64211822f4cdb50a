"""Blocks of a large body."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import fresnel

from radar_service.scattering.physical_optics.body_columns import WIDTH, body_columns
from radar_service.scattering.physical_optics.facets import areas
from radar_service.world.shapes import box
from tests.scattering.physical_optics.meshes import WAVELENGTH, echoes_toward, loaded, optical, plate

K = 2 * np.pi / WAVELENGTH
LENGTH, HEIGHT, STRIP = 270.0, 15.0, 0.004  # m
Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def test_a_long_ship_has_several_blocks_of_all_its_surface() -> None:
    mesh = box(270.0, 30.0, 20.0)
    made = body_columns(mesh)
    total = sum(areas(column.mesh.vertices[column.mesh.faces]).sum() for column in made)
    assert len(made) > 8 and total == pytest.approx(areas(mesh.vertices[mesh.faces]).sum())
    assert max(column.radius for column in made) < 1.5 * WIDTH
    assert all(len(column.triangle) == len(column.mesh.faces) for column in made)


def test_each_block_has_its_own_distance() -> None:
    antenna = np.array([0.0, 500.0, 20.0])
    distances = [column.distance(antenna) for column in body_columns(box(270.0, 30.0, 20.0))]
    assert min(distances) < 370.0 and max(distances) > 580.0


def test_a_small_body_is_one_block_as_it_is() -> None:
    (column,) = body_columns(box(20.0, 20.0, 20.0))
    assert len(column.triangle) == len(box(20.0, 20.0, 20.0).faces) and column.distance(
        np.array([0.0, 100.0, 5.0])
    ) == pytest.approx(100 - 200**0.5)


def strips(antenna: Floats) -> tuple[Floats, Floats, Complexes]:
    """Ranges, bearings and fields of upright strips of a ship's side, each in closed form (Fresnel integrals over its height, a
    sinc over its width)."""
    x = (np.arange(round(LENGTH / STRIP)) + 0.5) * STRIP - LENGTH / 2
    distance = np.hypot(x - antenna[0], antenna[1])
    scale = np.sqrt(2 * K / (np.pi * distance))
    low, high = fresnel(scale * (-HEIGHT / 2 - antenna[2])), fresnel(scale * (HEIGHT / 2 - antenna[2]))
    upright = ((high[1] - low[1]) - 1j * (high[0] - low[0])) / scale
    level = STRIP * np.sinc(K * (x - antenna[0]) / distance * STRIP / np.pi) * antenna[1] / distance
    field = 2 * np.sqrt(np.pi) / WAVELENGTH * upright * level * np.exp(-2j * K * distance)
    return distance, np.arctan2(x - antenna[0], -antenna[1]) % (2 * np.pi), field


def observed(distance: Floats, bearing: Floats, field: Complexes, boresight: Floats, ranges: Floats) -> Complexes:
    """What a beam of 1.9 degrees (Gaussian) and a pulse of 3 m (a squared cosine) make of fields."""
    beam = np.exp(-2.776 * ((bearing - boresight[:, None]) / np.deg2rad(1.9)) ** 2)
    columns = []
    for middle in ranges:
        offset = (distance - middle) / 3.0
        near = np.flatnonzero(np.abs(offset) < 1.0)
        columns.append(beam[:, near] @ (field[near] * np.cos(np.pi / 2 * offset[near]) ** 2))
    return np.stack(columns, axis=1)


@pytest.mark.parametrize(
    ("range_m", "degrees"), [(300.0, 0.0), (300.0, 20.0), (600.0, 35.0), (1500.0, 10.0), (1500.0, 60.0)]
)
def test_the_side_of_a_long_ship_has_no_beads(tmp_path: Path, range_m: float, degrees: float) -> None:
    """A side of 270 m by 15 m, by beam and pulse everywhere along it: within 2 % of the brightest spot, a sixth of
    1 dB. Pieces too long for the near field would show as beads of 10 % and more."""
    turn = np.deg2rad(degrees)
    antenna = np.array([range_m * np.sin(turn), range_m * np.cos(turn), 3.0])
    distance, bearing, field = strips(antenna)
    position, amplitude = echoes_toward(optical(loaded(tmp_path, plate(LENGTH, HEIGHT, 1))), antenna)
    apart = position - antenna
    away = np.linalg.norm(apart, axis=1)
    boresight = np.linspace(bearing.min(), bearing.max(), 61)
    ranges = np.arange(distance.min() - 3.0, distance.max() + 3.0, 1.5)
    exact = observed(distance, bearing, field, boresight, ranges)
    ours = amplitude * np.exp(-2j * K * away)
    computed = observed(away, np.arctan2(apart[:, 0], apart[:, 1]) % (2 * np.pi), ours, boresight, ranges)
    turned = np.vdot(computed, exact)
    assert np.abs(computed * turned / abs(turned) - exact).max() < 0.02 * np.abs(exact).max()
