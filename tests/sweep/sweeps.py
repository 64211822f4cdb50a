"""Small sweeps that tests share."""

from pathlib import Path
from typing import Any

import pytest

from radar_service.numerics.arithmetic_name import arithmetic
from radar_service.sweep.inputs import Inputs, inputs_of
from radar_service.sweep.layout import layout_of
from radar_service.sweep.sweep import Tally, run_sweep

SCENE = """
name = "small"
[radar]
azimuths = 60
beamwidth_deg = 8
range_max_m = 600
rpm = 60
pulse_s = 1e-6
[own_ship]
speed_kn = 10
[environment]
noise = true
[[body]]
name = "buoy"
shape = "point"
position_m = [0, 300, 10]
rcs_dbsm = 10
[[body]]
name = "cube"
mesh = "cube.obj"
position_m = [200, 100, 0]
"""
CUBE = """
v -5 -5 0
v 5 -5 0
v 5 5 0
v -5 5 0
v -5 -5 9
v 5 -5 9
v 5 5 9
v -5 5 9
f 1 3 2
f 1 4 3
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 2 3 7
f 2 7 6
f 3 4 8
f 3 8 7
f 4 1 5
f 4 5 8
"""
SPEC = """
scene = "small.toml"
seeds = 2
scans = 3
scans_per_chunk = 2
keep = ["video", "power", "truth"]
bins = 40
[vary]
"body.buoy.rcs_dbsm" = [5, 15]
"""


def written(folder: Path, spec: str = SPEC, scene: str = SCENE) -> Path:
    """The file of a specification, with its scene and the mesh of this."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "small.toml").write_text(scene)
    (folder / "cube.obj").write_text(CUBE)
    (folder / "sweep.toml").write_text(spec)
    return folder / "sweep.toml"


def inputs(folder: Path, spec: str = SPEC, scene: str = SCENE) -> Inputs:
    """The inputs of a sweep."""
    return inputs_of(written(folder, spec, scene))


def swept(folder: Path, spec: str = SPEC, scene: str = SCENE, **more: Any) -> tuple[Inputs, str, Tally]:
    """A sweep in `out.zarr` of a folder, its store and what became of it. more: as `run_sweep`."""
    of = inputs(folder, spec, scene)
    address = more.pop("address", str(folder / "out.zarr"))
    return of, address, run_sweep(of, layout_of(of), address, more.pop("arithmetic", arithmetic()), **more)


def content(address: str | Path) -> dict[str, bytes]:
    """All files of a store, by name."""
    root = Path(address)
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def open_dataset(address: str) -> Any:
    """The store as xarray opens it."""
    xarray = pytest.importorskip("xarray")
    return xarray.open_zarr(address, consolidated=False, chunks=None)
