"""The command `sweep`: what it prints, and what it refuses before it begins."""

import re
from contextlib import nullcontext
from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.sweep.store import SweepStore
from tests.limits import full_disk
from tests.sweep.sweeps import SPEC, written


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs are made in this process: those of others are tested in tests/sweep."""
    monkeypatch.setattr("radar_service.batch.worker_processes.processes", lambda jobs, memory: nullcontext())


@pytest.mark.usefixtures("in_process")
def test_a_sweep_is_made_and_found_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec, out = written(tmp_path, SPEC), tmp_path / "new" / "out.zarr"
    arguments = ["sweep", str(spec), "-o", str(out), "--jobs", "1"]
    assert main(arguments) == 0
    printed = capsys.readouterr()
    assert printed.out == f"{out}: 4 runs, 0 were there already, 0 failed\n"
    assert ": 4 of 4 runs, " in printed.err and " runs a second, 0 s left" in printed.err
    assert main(arguments) == 0
    assert capsys.readouterr().out == f"{out}: 0 runs, 4 were there already, 0 failed\n"
    written(tmp_path, "seed = 1" + SPEC)
    assert main(arguments) == 2
    assert "it is of another sweep: spec.seed is 0 there, and 1 here" in capsys.readouterr().err


@pytest.mark.usefixtures("in_process")
def test_a_sweep_with_labels_tells_its_class_balance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = written(tmp_path, SPEC.replace('"truth"', '"labels"'))
    assert main(["sweep", str(spec), "-o", str(tmp_path / "out.zarr"), "--jobs", "1"]) == 0
    line = capsys.readouterr().out.splitlines()[1]
    shares = dict(re.findall(r"(noise|range sidelobes and faint parts|bodies) ([\d.]+)%", line))
    assert line.startswith("cells by label: noise ") and len(shares) == 3
    assert sum(map(float, shares.values())) == pytest.approx(100.0, abs=0.02)  # two rounded digits each


@pytest.mark.usefixtures("in_process")
def test_failed_runs_are_printed_with_their_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = written(tmp_path, SPEC + '"body.cube.mesh" = ["cube.obj", "rubbish.obj"]\n')
    (tmp_path / "rubbish.obj").write_text("v nowhere")
    out = tmp_path / "out.zarr"
    assert main(["sweep", str(spec), "-o", str(out), "--jobs", "1", "--max-failures", "1"]) == 1
    printed = capsys.readouterr()
    lines = printed.out.splitlines()
    assert lines[0] == f"{out}: 2 runs, 0 were there already, 1 failed, 5 left" and lines[1].startswith(
        "run 2: small.toml, "
    )
    assert printed.err.startswith("run 0: 1 of 8 runs") and SweepStore(str(out)).failures.keys() == {2}


def test_a_dry_run_does_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = written(tmp_path, SPEC)
    before = {path.name for path in tmp_path.iterdir()}
    assert main(["sweep", str(spec), "--dry-run", "-o", str(tmp_path / "out.zarr")]) == 0
    assert capsys.readouterr().out.startswith("4 runs of 3 scans of 60 x 40\n")
    assert {path.name for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    ("options", "spec", "message"),
    [
        (["-o", "x.npz"], SPEC, '"x.npz" does not end in .zarr, the format that is written; give it that ending'),
        ([], SPEC, "-o: name the store to write"),
        (["-o", "x.zarr", "--jobs", "2", "--scheduler", "tcp://x"], SPEC, "not allowed with argument"),
        (["-o", "x.zarr", "--scheduler", "tcp://127.0.0.1:1"], SPEC, "no scheduler of Dask answers there"),
        (["-o", "x.zarr"], 'scene = "nowhere"', "neither a file nor a packaged scene has this name"),
        (["-o", "x.zarr"], SPEC.replace("[5, 15]", "[nan]"), "no finite number"),
        (
            ["-o", "x.zarr"],
            SPEC.replace("seeds = 2", "seeds = 1_000_000"),
            "runs (2 of body.buoy.rcs_dbsm x 1000000 of seeds)",
        ),
        (["-o", "sweep.toml/x.zarr"], SPEC, "sweep.toml: a file is in the way of this folder"),
    ],
)
def test_what_cannot_be_is_told_in_a_line_before_anything_begins(
    options: list[str], spec: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr("radar_service.batch.dask_cluster.CONNECT_SECONDS", 0.2)
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, spec)
    try:
        status = main(["sweep", str(path), *options])
    except SystemExit as error:  # of argparse
        status = int(error.code or 0)
    assert status == 2 and message in capsys.readouterr().err.splitlines()[-1]
    assert not (tmp_path / "x.zarr").exists()


@pytest.mark.usefixtures("in_process")
def test_a_full_file_system_ends_it_and_leaves_nothing_that_looks_whole(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Files may have 4 kB here: the layout fits, the arrays of runs do not."""
    spec, out = written(tmp_path, 'scene = "small.toml"\nkeep = ["field"]'), tmp_path / "out.zarr"
    with full_disk(4096):
        status = main(["sweep", str(spec), "-o", str(out), "--jobs", "1"])
    last = capsys.readouterr().err.splitlines()[-1]
    assert (status, last) == (2, f"{out}: File too large; make room, and the same command goes on")
    store = SweepStore(str(out))
    assert not store.finished.any() and not [*out.rglob("*.partial")]
