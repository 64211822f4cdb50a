"""The file of scans: its documented layout, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.scans import file as scan_file
from tests.scans.test_scan import SCENE


@pytest.fixture
def simulator() -> rs.Simulator:
    return rs.Simulator(rs.load_scene(SCENE), "fast", seed=3)


def test_the_documented_layout_is_the_one_that_is_checked() -> None:
    rows = [line.split("|")[1:4] for line in (scan_file.__doc__ or "").splitlines() if line.startswith("| ")][1:]
    named = {
        name.strip(): shape.strip(" ()").replace(",", "").replace(" ", "")
        for names, shape, _ in rows for name in names.replace(", optional", "").split(",")
    }  # fmt: skip
    assert named == {"format": ""} | scan_file.SHAPES | scan_file.OPTIONAL


def test_only_files_of_scans_are_loaded(simulator: rs.Simulator, tmp_path: Path) -> None:
    scan = simulator.scan()
    with pytest.raises(ValueError, match=r"x\.txt: a file of scans ends in \.npz"):
        scan.save(tmp_path / "x.txt")
    assert not list(tmp_path.iterdir())
    (tmp_path / "text.npz").write_text("no arrays")
    np.savez(tmp_path / "other.npz", a=1)
    np.savez(tmp_path / "newer.npz", format=2)
    for name, text in (("text", "not a file of scans"), ("other", "format None"), ("newer", "format 2 is not 1")):
        with pytest.raises(ValueError, match=text):
            rs.load_scan(tmp_path / f"{name}.npz")
    scan.save(tmp_path / "a.npz")
    arrays = scan_file.read_arrays(tmp_path / "a.npz")
    for wrong, text in (({"range": np.zeros(3)}, "range has shape"), ({"colour": 1}, r"\['colour'\] not known")):
        with pytest.raises(ValueError, match=text):
            scan_file.write_arrays(tmp_path / "b.npz", arrays | wrong)
    del arrays["power"]
    scan_file.write_arrays(tmp_path / "b.npz", arrays)
    with pytest.raises(ValueError, match="holds no power"):
        rs.load_scan(tmp_path / "b.npz")
