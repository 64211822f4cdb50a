"""What the look into the land mask costs a coast under way, which asks for it once a point and passage."""

import time
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.trace.line_of_sight import OcclusionScene
from tests.measurements.places import low_coast

PAIRS = 12


@pytest.mark.bench
def test_a_coast_takes_at_most_a_twentieth_more_with_its_mask(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a million triangles and echoes at 8 kn, 2048 azimuths: CPU time of scans with the mask and without, by turns
    (required: 1.05)."""
    made = low_coast(tmp_path)
    simulators = [rs.Simulator(made, "balanced", threads=1) for _ in range(2)]
    masks, seconds = [vars(OcclusionScene)["land"], property(lambda scene: None)], np.zeros((PAIRS + 1, 2))
    for turn in range(2 * PAIRS + 2):
        k, which = turn // 2, (turn + turn // 2) % 2  # who is first changes from pair to pair
        monkeypatch.setattr(OcclusionScene, "land", masks[which])
        begin = time.process_time()
        simulators[which].scan()
        seconds[k, which] = time.process_time() - begin
    ratio = seconds[1:, 0] / seconds[1:, 1]
    print(
        f"with the mask {np.median(seconds[1:, 0]):.2f} s, without {np.median(seconds[1:, 1]):.2f} s; pairs {np.round(ratio, 3)}"
    )
    assert np.median(ratio) < 1.05
