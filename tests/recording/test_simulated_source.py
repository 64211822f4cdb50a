"""A simulator as a source of spokes."""

import json

import pytest

from radar_service.recording.simulated_source import SimulatedSource
from radar_service.stream.source import SceneOrder
from tests.recording.scenes import AZIMUTHS, MOVING, simulator


@pytest.mark.same_bytes
def test_it_has_what_the_simulator_has() -> None:
    made = simulator()
    source = SimulatedSource(made, SceneOrder(MOVING))
    assert source.scene.radar == made.scene.radar and source.scene.body_count == 2
    assert (source.seed, source.fidelity, source.noise_power) == (made.seed, made.fidelity, made.noise_power)
    assert source.range is made.range and source.range_step == made.range_step and source.trees == made.trees
    assert source.plan.as_dict() == made.plan.as_dict()
    source.skip_to(2)
    assert next(source.blocks(size=5)).first == 2 * AZIMUTHS
    assert source.truth(1.0) == made.truth(1.0) and source.spare() is None
    assert json.loads(source.truth_lines(1)[-1].text)["type"] == "snapshot"
    source.close()
