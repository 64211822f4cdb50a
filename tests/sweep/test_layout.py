"""The layout of a store: sizes, chunks, coordinates, and runs that do not fit together."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.sweep.layout import CHUNK_BYTES, StoreLayout, layout_of
from radar_service.sweep.spec import SweepError
from tests.sweep.sweeps import SCENE, SPEC, inputs, written


def layout(folder: Path, spec: str = SPEC, scene: str = SCENE) -> StoreLayout:
    return layout_of(inputs(folder, spec, scene))


def test_a_run_is_whole_chunks_of_each_array(tmp_path: Path) -> None:
    of = layout(tmp_path)
    assert of.sizes == {"run": 4, "scan": 3, "azimuth": 60, "range": 40, "body": 2, "crossing": 4, "plot": 40, "label": 1}
    for each in of.arrays:
        assert each.dims[0] == "run" and of.chunks(each)[0] == 1 and of.chunks(each)[2:] == of.shape(each)[2:]
    video = next(each for each in of.arrays if each.name == "video")
    assert (of.shape(video), of.chunks(video)) == ((4, 3, 60, 40), (1, 2, 60, 40))
    expected = 3 * (60 * 8 + 60 * 40 * (1 + 4) + 4 * (4 + 1 + 8 * 8))
    assert of.bytes_per_run == expected and of.bytes == 4 * expected and of.chunk_bytes == expected * 2 // 3


def test_chunks_are_of_some_size_by_default(tmp_path: Path) -> None:
    of = layout(tmp_path, SPEC.replace("scans = 3\nscans_per_chunk = 2", "scans = 100_000"))
    assert of.scans_per_chunk == CHUNK_BYTES // (60 * 40 * 4)
    assert layout(tmp_path, SPEC.replace("scans_per_chunk = 2", "")).scans_per_chunk == 3


def test_what_is_known_before_the_first_run_is_a_coordinate(tmp_path: Path) -> None:
    of = layout(
        tmp_path, SPEC.replace("[vary]", '[vary]\n"environment.noise" = [true]\n"body.cube.position_m" = [[200, 100, 0]]')
    )
    values = {name: each.values.tolist() for name, each in of.coordinates.items()}
    assert (
        values["run"] == [0, 1, 2, 3] and values["body_name"] == ["buoy", "cube"] and values["scene"] == ["small.toml"] * 4
    )
    assert values["body.buoy.rcs_dbsm"] == [5.0, 5.0, 15.0, 15.0] and values["environment.noise"] == [True] * 4
    assert values["body.cube.position_m"] == ["[200, 100, 0]"] * 4 and len(set(values["seed"])) == 4
    assert values["radar_id"] == [""] * 4
    assert values["range"] == pytest.approx((np.arange(40) + 0.5) * 15.0, rel=0.01)  # 600 m, but for the last cell
    assert all(each.values.shape == tuple(of.sizes[dim] for dim in each.dims) for each in of.coordinates.values())


def test_labels_are_as_wide_as_their_numbers(tmp_path: Path) -> None:
    of = layout(tmp_path, SPEC.replace('"truth"', '"labels"'))
    assert {each.name: each.dtype for each in of.arrays}["labels"] == "uint16"
    assert of.labels["small.toml"]["256"] == "buoy" and of.labels["small.toml"]["257"] == "cube"


def test_ranges_that_differ_are_told_run_by_run(tmp_path: Path) -> None:
    """Also where a draw may change them."""
    for values in ("[600, 1200]", "{uniform = [600, 700]}"):
        of = layout(tmp_path, SPEC + f'"radar.range_max_m" = {values}')
        assert "range" not in of.coordinates and [each.name for each in of.arrays][:2] == ["range_first", "range_step"]
    assert "range" in layout(tmp_path, SPEC + '"radar.rpm" = [24, 48]').coordinates


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((("bins = 40", ""), ("[vary]", '[vary]\n"radar.range_max_m" = [600, 300]')),
         r"^run 0 has 301 bins, and run 4 151; all share arrays: set bins to 151 or less$"),
        ((("[vary]", '[vary]\n"radar.azimuths" = [60, 90]'),),
         "^run 0 has 60 azimuths, and run 4 90; all share arrays: give radars of as many azimuths, or make a sweep of each$"),
        ((('"small.toml"', '["small.toml", "open-sea"]'), ("[vary]\n", "[vary]\n#")), "^run 0 has 60 azimuths, and run 2 720"),
    ],
)  # fmt: skip
def test_runs_that_share_no_arrays_are_refused(change: Any, message: str, tmp_path: Path) -> None:
    spec = SPEC
    for old, new in change:
        spec = spec.replace(old, new)
    with pytest.raises(SweepError, match=message):
        layout(tmp_path, spec)


def test_a_scene_whose_files_are_rubbish_is_refused_before_anything_begins(tmp_path: Path) -> None:
    written(tmp_path)
    of = inputs(tmp_path)
    broken = type(of)(of.spec, (type(of.scenes[0])("small.toml", of.scenes[0].content, {"cube.obj": b"rubbish"}),))
    with pytest.raises(SweepError, match=r"^small.toml, body.buoy.rcs_dbsm = 5: .*cube.obj"):
        layout_of(broken)
