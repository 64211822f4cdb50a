"""What a sweep will take, before it begins."""

from pathlib import Path

import pytest

from radar_service.sweep.estimate import COPIES, HOUR, estimate
from radar_service.sweep.layout import layout_of
from radar_service.sweep.store import SweepStore
from tests.sweep.sweeps import SPEC, inputs, swept


def test_it_adds_up_what_it_measures(tmp_path: Path) -> None:
    of = inputs(tmp_path, SPEC.replace("seeds = 2", "seeds = 50"))
    layout = layout_of(of)
    taken = estimate(of, layout)
    (cost,) = taken.scenes
    assert cost.runs == 100 and cost.scan == pytest.approx(1.0 / cost.realtime_factor)  # a scan is of a second
    assert taken.cpu_hours == pytest.approx(100 * (cost.set_up + 3 * (cost.scan + cost.write)) / HOUR)
    assert taken.memory > COPIES * layout.chunk_bytes and min(cost.set_up, cost.scan, cost.write) > 0.0
    lines = str(taken).splitlines()
    assert lines[0] == "100 runs of 3 scans of 60 x 40" and "CPU hours on this machine" in lines[1]
    assert lines[-2].startswith(f"{layout.bytes / 1e6:.3g} MB of arrays") and "memory a worker" in lines[-1]


def test_bytes_are_those_that_a_sweep_leaves(tmp_path: Path) -> None:
    """One scan stands for all: noise compresses alike. The marks and coordinates of four runs are left out, 2 kB."""
    of, address, _ = swept(tmp_path, SPEC)
    store = SweepStore(address)
    files = [path for each in store.variables for path in (tmp_path / "out.zarr" / each.name / "c").rglob("*")]
    there = sum(path.stat().st_size for path in files if path.is_file())
    assert estimate(of, layout_of(of)).stored == pytest.approx(there, rel=0.15)


def test_the_specification_as_printed_has_a_time_too(tmp_path: Path) -> None:
    of = inputs(tmp_path, 'scene = "small.toml"\nfidelity = "documented"')
    assert estimate(of, layout_of(of)).scenes[0].realtime_factor > 0.0
