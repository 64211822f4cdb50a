"""What the stream needs of a simulator, and what it makes of its range cells."""

import pytest

from radar_service.service.scene_request import ProcessSimulator, cell_layout
from tests.scenes import averaging
from tests.service.fake import BINS, STEP, FakeEngine, scene


def test_tests_have_what_computes_in_the_process_of_a_world() -> None:
    source: ProcessSimulator = FakeEngine(scene())
    assert {name for name in dir(ProcessSimulator) if not name.startswith("_")} <= set(dir(source))


def test_cells_become_bins_out_to_a_range() -> None:
    to = cell_layout(FakeEngine(scene()).info, 5, 100.0)
    assert (to.samples, to.bins) == (10, 5) and to.range == pytest.approx(100.0) and to.step == pytest.approx(2 * STEP)
    assert cell_layout(FakeEngine(scene()).info, None, None).bins == BINS
    averaged = FakeEngine(scene(**averaging({"azimuths": 60, "rpm": 60}, 5)))
    assert cell_layout(averaged.info, None, None).pulses == 5 and to.pulses == 1
