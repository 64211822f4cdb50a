"""Files that commands write: folders are made, nothing is overwritten unasked, and a full disk leaves nothing half."""

import ast
import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from radar_service.__main__ import main
from radar_service.commands.scan import write_png
from radar_service.display.film import write_gif
from radar_service.display.picture import render_image
from radar_service.scans.dataset import exporter
from radar_service.scans.scan import Scan, save_scans
from radar_service.simulator import Simulator
from radar_service.terminal.output_files import make_folder, named_errors, prepare, write_file, written
from tests.limits import full_disk
from tests.scenes import point
from tests.scenes import scene as scene_of

ROOT = Path(__file__).parents[2]
LIMIT = 1000  # bytes of a file, as where the disk is full
Writer = Callable[[Path, Scan, Simulator], object]
NOISE = np.random.default_rng(5).integers(0, 255, (60, 80)).astype(np.uint8)
WRITERS: dict[str, Writer] = {
    "a.npz": lambda path, scan, simulator: save_scans(path, [scan]),
    "a.zarr": lambda path, scan, simulator: exporter(path)(path, [scan], {}),
    "a.nc": lambda path, scan, simulator: exporter(path)(path, [scan], {}),
    "a.png": lambda path, scan, simulator: write_png(path, scan, simulator),
    "a.gif": lambda path, scan, simulator: write_gif(path, [render_image(NOISE, 10.0, 20.0, size=200)] * 2, 5),
    "a.json": lambda path, scan, simulator: write_file(path, "x" * (LIMIT + 1)),
}


def test_folders_are_made_and_files_are_kept(tmp_path: Path) -> None:
    old, new = tmp_path / "old.png", tmp_path / "a" / "b" / "new.png"
    old.write_text("mine")
    with pytest.raises(FileExistsError, match="it exists already; give --overwrite, or another name"):
        prepare((new, None, old), overwrite=False)
    assert not new.parent.exists()
    prepare((new, None, old), overwrite=True)
    assert new.parent.is_dir() and old.read_text() == "mine"


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="a file is in the way of this folder; name another") as caught:
        make_folder(tmp_path / "file")
    assert caught.value.filename == str(tmp_path / "file")


@pytest.mark.parametrize(
    ("command", "option", "name"),
    [
        ("scan", "-o", "a.npz"), ("scan", "--png", "a.png"), ("scan", "--truth", "a.jsonl"), ("record", "-o", "a.mcap"),
        ("plots", "-o", "a.json"), ("plots", "--png", "a.png"), ("serve", "--record", "a.mcap"),
    ],
)  # fmt: skip
def test_no_command_overwrites_unasked(
    command: str, option: str, name: str, one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if name.endswith(".mcap"):
        pytest.importorskip("mcap", reason="the extra `record` is absent")
    (tmp_path / name).write_text("mine")
    needed = ["-o", str(tmp_path / "other.npz")] if command == "scan" and option != "-o" else []
    assert main([command, str(one_target), option, str(tmp_path / name), *needed]) == 2
    assert capsys.readouterr().err == f"{tmp_path / name}: it exists already; give --overwrite, or another name\n"
    assert (tmp_path / name).read_text() == "mine" and not (tmp_path / "other.npz").exists()


def test_a_command_overwrites_where_it_may_and_makes_folders(one_target: Path, tmp_path: Path) -> None:
    out = tmp_path / "a" / "b" / "scan.npz"
    assert main(["scan", str(one_target), "-o", str(out)]) == 0
    first = out.stat().st_mtime_ns
    assert main(["scan", str(one_target), "-o", str(out), "--overwrite"]) == 0 and out.stat().st_mtime_ns > first


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_nothing_half_and_what_was_there(name: str, tmp_path: Path) -> None:
    if name.endswith((".zarr", ".nc")):
        pytest.importorskip("zarr", reason="the extra `xarray` is absent")
    radar = {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "pulse_s": 1e-6}
    simulator = Simulator(scene_of([point("a", 0, 300)], radar=radar), "fast")
    scan, path = simulator.scan(), tmp_path / name
    for before in ([], [name]):
        with full_disk(LIMIT), pytest.raises(OSError, match="File too large") as caught:
            WRITERS[name](path, scan, simulator)
        assert (caught.value.errno, caught.value.filename) == (errno.EFBIG, str(path))
        assert os.listdir(tmp_path) == before and (not before or path.read_bytes() == b"mine")
        path.write_bytes(b"mine")
    WRITERS[name](path, scan, simulator)
    assert os.listdir(tmp_path) == [name] and (path.is_dir() or path.read_bytes() != b"mine")


def test_a_folder_takes_the_place_of_a_folder_and_a_link_stays(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "old").touch()
    (tmp_path / "link").symlink_to(tmp_path / "there")
    with written(tmp_path / "link") as part:
        part.mkdir()
        (part / "new").touch()
    assert (tmp_path / "link").is_symlink() and os.listdir(tmp_path / "there") == ["new"]
    (tmp_path / "full").symlink_to("/dev/full")  # no device is replaced
    with pytest.raises(OSError, match="No space left on device") as caught:
        write_file(tmp_path / "full", "x")
    assert caught.value.filename == str(tmp_path / "full") and Path("/dev/full").is_char_device()


def test_what_a_program_says_gets_the_name(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="a.zarr: the program ended with 1"), named_errors("a.zarr"):
        raise OSError("the program ended with 1")


def test_standard_output_is_named_where_its_disk_is_full() -> None:
    with Path("/dev/full").open("wb") as full:
        command = [sys.executable, "-m", "radar_service", "schema"]
        ended = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert (ended.returncode, ended.stderr) == (2, "standard output: No space left on device\n")


STREAMS = {  # files that open others, and why these may be cut
    "radar_service/kernels/build_backend.py": "a trial of a compiler, in a folder that goes",
    "radar_service/recording/recording_file.py": "a cut recording can be read",
    "radar_service/ports/udp/capture.py": "a cut capture can be read",
    "radar_service/ports/rest/bodies.py": "an upload, in a folder that goes",
    "radar_service/ports/rest/scene_routes.py": "an upload, in a folder that goes",
    "radar_service/bench/video.py": "a scene for a service, in a folder that goes",
    "radar_service/radar_feed.py": "a scene for a child process, in a folder that goes",
    "radar_service/processes/fork_server_main.py": "a file of the kernel",
    "radar_service/processes/limits.py": "a file of the kernel",
}


def test_every_writer_of_the_package_is_one_of_these() -> None:
    """A call that writes to a path writes to the `part` of `written`, or stands in STREAMS."""
    found = set()
    for file in (*ROOT.glob("radar_service/**/*.py"), *ROOT.glob("clients/**/*.py")):
        text = file.read_text()
        nodes = ast.walk(ast.parse(text)) if any(f"{name}(" in text for name in WRITING) else ()
        if any(isinstance(node, ast.Call) and _writes(node) for node in nodes):
            found.add(file.relative_to(ROOT).as_posix())
    assert found == set(STREAMS)


WRITING = ("open", "savefig", "to_zarr", "to_netcdf", "write_text", "write_bytes")


def _writes(call: ast.Call) -> bool:
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    of = ast.unparse(call.func.value) if isinstance(call.func, ast.Attribute) else ""
    texts = [word.value for word in (*call.args, *(key.value for key in call.keywords)) if isinstance(word, ast.Constant)]
    if name == "open":
        return of != "part" and any(isinstance(text, str) and set(text) & set("wxa+") and len(text) < 4 for text in texts)
    if name in ("savefig", "to_zarr", "to_netcdf"):
        return ast.unparse(call.args[0]) not in ("part", "buffer", "drawn", "out", "MemoryStore(files)")  # bytes in memory
    return name in ("write_text", "write_bytes") and not of.removeprefix("(").startswith("part")
