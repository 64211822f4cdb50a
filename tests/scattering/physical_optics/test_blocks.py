"""Blocks of a large body."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.blocks import BLOCK, blocks
from radar_service.scattering.physical_optics.facets import areas
from radar_service.scene.shapes import box


def test_a_long_ship_has_several_blocks_of_all_its_surface() -> None:
    mesh = box(270.0, 30.0, 20.0)
    made = blocks(mesh)
    total = sum(areas(block.mesh.vertices[block.mesh.faces]).sum() for block in made)
    assert len(made) > 8 and total == pytest.approx(areas(mesh.vertices[mesh.faces]).sum())
    assert max(block.radius for block in made) < 1.5 * BLOCK
    assert all(len(block.triangle) == len(block.mesh.faces) for block in made)


def test_each_block_has_its_own_distance() -> None:
    antenna = np.array([0.0, 500.0, 20.0])
    distances = [block.distance(antenna) for block in blocks(box(270.0, 30.0, 20.0))]
    assert min(distances) < 370.0 and max(distances) > 580.0


def test_a_small_body_is_one_block_as_it_is() -> None:
    (block,) = blocks(box(20.0, 20.0, 20.0))
    assert len(block.triangle) == len(box(20.0, 20.0, 20.0).faces) and block.distance(
        np.array([0.0, 100.0, 5.0])
    ) == pytest.approx(100 - 200**0.5)
