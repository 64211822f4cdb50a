"""The house keeps its order: imports point one way, and each heavy library has one home (docs/code-map.md)."""

import ast
import itertools
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
GROUND = (
    "public_names",
    "kernels",
    "numerics",
    "processes",
    "records",
    "terminal",
    "plug_ins",
    "strict_json",
    "wire",
)  # upward, as PHYSICS
PHYSICS = (
    "radar", "world", "trace", "propagation", "scattering", "echo", "receive", "clutter", "stages", "engine", "sources", "plan",
)  # fmt: skip  # upward, each may use all below it
SIMULATOR = (*GROUND, *PHYSICS, "scene_file", "truth", "errors", "display", "scans", "spoke_source", "simulation")
SERVICE = (*GROUND, "radar", "world", "stages", "scene_file", "receive", "errors", "display", "spoke_source")
BELOW: dict[str, tuple[str, ...]] = {  # what a room may use besides itself; upward, as the table of rooms has them
    **{room: GROUND[:i] for i, room in enumerate(GROUND)},
    **{room: (*GROUND, *PHYSICS[:i]) for i, room in enumerate(PHYSICS)},
    "scene_file": (*GROUND, "radar", "world", "scattering", "stages"),
    "truth": (*GROUND, *PHYSICS[: PHYSICS.index("receive")], "stages"),
    "errors": (*GROUND, "radar", "world"),
    "display": (*GROUND, "radar"),
    "scans": (*GROUND, "radar", "display"),
    "spoke_source": (*GROUND, "radar", "world"),
    "effects": (*GROUND, *PHYSICS),
    "simulation": (*GROUND, *PHYSICS, "truth", "errors", "scans"),
    "simulator": SIMULATOR,
    "__init__": (*GROUND, "world", "scene_file", "scans", "simulator"),
    "service": SERVICE,
    "recording": (*SERVICE, "scans", "service"),
    "ports": (*SERVICE, "service", "recording"),
    "radar_feed": (*SIMULATOR, "simulator"),
    "pytest_plugin": ("radar_feed",),
    "plots": (*GROUND, *PHYSICS[: PHYSICS.index("plan")], "truth", "display", "scans", "simulator"),
    "batch": GROUND,
    "bench": (*SIMULATOR, "simulator", "plots", "batch"),
    "sweep": (*SIMULATOR, "simulator", "plots", "batch", "bench"),
    "study": (*SIMULATOR, "simulator", "batch"),
    "commands": (
        *SIMULATOR,
        "simulator",
        "__init__",
        "service",
        "recording",
        "ports",
        "plots",
        "batch",
        "bench",
        "sweep",
        "study",
    ),
}
PARTS = {  # of rooms with several, upward; "" are the modules that are not named
    "service": ("", "codecs", "fanout", "radio"),
    "ports": ("", "http", "feed", "recorder", "rest", "nmea", "nmea_in", "ais", "signalk", "app", "running", "registry"),
    "scene_file": ("model", "readers", "checks", ""),
    "bench": ("scenario", "trackers", "scores", "", "detection", "ladder"),
}
CLIENT_MAY = (
    "radar_service.wire",
    "radar_service.display",
    "radar_service.scans.file",
    "radar_service.terminal.output_files",
)
HOMES = {
    "trimesh": ("radar_service.scene_file.readers",),
    "pyproj": ("radar_service.world.geo",),
    "embreex": ("radar_service.trace.embree",),
    "fastapi": ("radar_service.ports",),
    "starlette": ("radar_service.ports",),
    "uvicorn": ("radar_service.ports.http", "radar_service.ports.running", "radar_service.__main__"),
    "pydantic": (
        "radar_service.stages",
        "radar_service.scene_file",
        "radar_service.ports.rest",
        "radar_service.bench.scenario",
        "radar_service.bench.ladder.series",
        "radar_service.sweep.spec",
    ),
    "pydantic_core": ("radar_service.scene_file.validation_messages",),
    "prometheus_client": ("radar_service.ports.rest",),
    "zstandard": ("radar_service.wire", "radar_service.recording.chunk_table"),
    "msgpack": ("radar_service.wire",),
    "websockets": ("clients.ppi", "radar_service.radar_feed", "radar_service.bench.trackers.websocket_tracker"),
    "PIL": ("radar_service.scene_file.readers", "radar_service.display", "radar_service.study"),
    "stonesoup": ("radar_service.bench",),
    "matplotlib": (
        "radar_service.bench.run_picture",
        "radar_service.plots.picture",
        "radar_service.bench.detection.report",
        "radar_service.bench.ladder.report",
        "radar_service.scans.scan",
        "radar_service.study",
    ),
    "threadpoolctl": ("radar_service.numerics.parallel",),
    "xarray": ("radar_service.scans.scan", "radar_service.scans.dataset"),
    "zarr": ("radar_service.scans.dataset", "radar_service.sweep.store"),
    "distributed": ("radar_service.batch.dask_cluster",),
    "pytest": ("radar_service.pytest_plugin",),
    "mcap": ("radar_service.recording.mcap_library",),
}


parsed = cache(ast.parse)  # several rules look at each file


def within(module: str, *homes: str) -> bool:
    """Whether a module is one of `homes` or lies inside one."""
    return any(module == home or module.startswith(f"{home}.") for home in homes)


def room(module: str) -> str:
    """The part of radar_service that a module belongs to: radar_service.echo.moving is in echo."""
    return (module.split(".") + ["__init__"])[1]


def fault(importer: str, imported: str) -> str | None:
    """The rule that this import breaks, in a sentence, or None."""
    library = imported.split(".")[0]
    if library in HOMES and not within(importer, *HOMES[library]):
        return f"{importer} imports {imported}: {library} lives in {' and '.join(HOMES[library])} alone"
    if within(importer, "clients"):
        if within(imported, "radar_service", "scenes") and not within(imported, *CLIENT_MAY):
            return f"{importer} imports {imported}: clients use {' and '.join(CLIENT_MAY)} alone"
        return None
    if within(importer, "radar_service") and within(imported, "clients"):
        return f"{importer} imports {imported}: the service does not know its clients"
    if within(importer, "radar_service") and within(imported, "radar_service"):
        return inner_fault(importer, imported)
    return None


def inner_fault(importer: str, imported: str) -> str | None:
    """The same, between modules of radar_service."""
    here, there = room(importer), room(imported)
    if here == "__main__":
        return None
    if here not in BELOW:
        return f"{importer}: the house has no place for it; the parts are {', '.join(BELOW)}"
    if here == there and here in PARTS:
        return part_fault(importer, imported)
    if there in (*BELOW[here], here):
        return None
    return f"{importer} imports {imported}: {here} may use {', '.join(BELOW[here])} and nothing above"


def part_fault(importer: str, imported: str) -> str | None:
    """The same, between the parts of a room."""
    parts = PARTS[room(importer)]
    here, there = (next((part for part in module.split(".")[2:3] if part in parts), "") for module in (importer, imported))
    if parts.index(there) <= parts.index(here):
        return None
    return f"{importer} imports {imported}: in {room(importer)} it may use no part above its own ({' < '.join(parts)})"


def modules(*packages: str) -> dict[str, Path]:
    """Every module of some packages, and its file."""
    files = [file for package in packages for file in sorted((ROOT / package).rglob("*.py"))]
    return {".".join(f.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): f for f in files}


HOUSE = modules("radar_service", "clients", "scenes")


def imports(module: str, source: str, is_package: bool, with_types: bool = True) -> Iterator[str]:
    """Full names of what a module imports, wherever in it; `from package import module` names the module. with_types: also what
    it imports for its types alone."""
    body = parsed(source).body
    if not with_types:
        body = [part for part in body if not (isinstance(part, ast.If) and "TYPE_CHECKING" in ast.unparse(part.test))]
    for node in itertools.chain.from_iterable(map(ast.walk, body)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = module.split(".")[: len(module.split(".")) - node.level + is_package] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                yield f"{origin}.{alias.name}" if f"{origin}.{alias.name}" in HOUSE else origin


def test_imports_point_one_way() -> None:
    faults = [
        f"{file.relative_to(ROOT)}: {message}"
        for module, file in HOUSE.items()
        for name in imports(module, file.read_text(encoding="utf-8"), file.name == "__init__.py")
        if (message := fault(module, name))
    ]
    assert not faults, "\n".join(faults)


def test_the_whole_house_is_checked() -> None:
    for name in PHYSICS:
        assert f"radar_service.{name}" in HOUSE, f"radar_service/{name}: a room of the house has no folder"
    assert {"radar_service.__main__", "radar_service.wire.format", "clients.ppi.client"} <= set(HOUSE)


@pytest.mark.parametrize(
    ("importer", "imported", "rule"),
    [
        ("radar_service.world.scene", "radar_service.trace.embree", "nothing above"),
        ("radar_service.world.scene", "radar_service.scene_file.readers.mesh", "nothing above"),
        ("radar_service.radar.antenna", "radar_service.world.scene", "nothing above"),
        ("radar_service.echo.moving", "radar_service.receive.beam", "nothing above"),
        ("radar_service.display.ppi", "radar_service.service.spokes", "nothing above"),
        ("radar_service.receive.beam", "radar_service.simulator", "nothing above"),
        ("radar_service.engine.pipeline", "radar_service.plan.culling", "nothing above"),
        ("radar_service.plan.realtime", "radar_service.simulator", "nothing above"),
        ("radar_service.ports.app", "radar_service.simulator", "nothing above"),
        ("radar_service.ports.app", "radar_service", "nothing above"),
        ("radar_service.service.fanout.hub", "radar_service.ports.app", "nothing above"),
        ("radar_service.service.spokes", "radar_service.service.fanout.hub", "no part above"),
        ("radar_service.ports.http.server", "radar_service.ports.rest.rest_port", "no part above"),
        ("radar_service.records.spokes", "radar_service.world.scene", "nothing above"),
        ("radar_service.simulator", "radar_service.service.fanout.hub", "nothing above"),
        ("radar_service.simulator", "radar_service.__main__", "nothing above"),
        ("radar_service.study.chart", "radar_service.service.fanout.hub", "nothing above"),
        ("radar_service", "radar_service.service", "nothing above"),
        ("radar_service.glue", "radar_service.numerics.frames", "no place"),
        ("radar_service.ports.app", "clients.ppi", "does not know its clients"),
        ("radar_service.service.radio.station", "radar_service.recording.recording", "nothing above"),
        ("radar_service.recording.recording", "mcap.reader", "mcap lives in"),
        ("clients.ppi.client", "radar_service.service.fanout.hub", "clients use"),
        ("clients.ppi.client", "radar_service.records.spokes", "clients use"),
        ("clients.ppi.client", "radar_service.displays", "clients use"),
        ("radar_service.scattering.rays", "trimesh", "trimesh lives in"),
        ("radar_service.trace.ray_sampling", "embreex.rtcore_scene", "embreex lives in"),
        ("radar_service.world.scene", "pydantic", "pydantic lives in"),
        ("radar_service.scene_file.model.scene", "radar_service.scene_file.readers.mesh", "no part above"),
        ("radar_service.simulator", "uvicorn", "uvicorn lives in"),
        ("clients.ppi.client", "fastapi", "fastapi lives in"),
    ],
)
def test_rules_can_be_broken(importer: str, imported: str, rule: str) -> None:
    message = fault(importer, imported)
    assert message is not None and rule in message and message.startswith(importer)


@pytest.mark.parametrize(
    ("importer", "imported"),
    [
        ("radar_service.echo.moving", "radar_service.world.scene"),
        ("radar_service.echo.moving", "radar_service.propagation.multipath"),
        ("radar_service.scene_file.load", "radar_service.scene_file.document"),
        ("radar_service.simulator", "radar_service.engine.pipeline"),
        ("radar_service.__main__", "radar_service.ports.app"),
        ("clients.ppi.client", "radar_service.wire.format"),
        ("clients.ppi.scans", "radar_service.display.ppi"),
        ("radar_service.trace.embree", "embreex.rtcore_scene"),
        ("radar_service.radar.antenna", "scipy.special"),
    ],
)
def test_rules_allow_the_rest(importer: str, imported: str) -> None:
    assert fault(importer, imported) is None


def test_each_room_may_use_only_those_before_it() -> None:
    order = list(BELOW)
    assert sorted(order) == sorted({room(module) for module in HOUSE if within(module, "radar_service")} - {"__main__"})
    for name, below in BELOW.items():
        assert all(order.index(other) < order.index(name) for other in below), name


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = {
        module: {
            name
            for name in imports(module, file.read_text(encoding="utf-8"), file.name == "__init__.py", with_types=False)
            if name in HOUSE and name != module
        }
        for module, file in HOUSE.items()
    }
    TopologicalSorter(graph).prepare()  # raises CycleError, which names one


def test_imports_are_found_in_every_form() -> None:
    source = """
import numpy as np, trimesh.util
from radar_service.radar import antenna
from radar_service.numerics.frames import direction
from . import embree
from ..world.scene import Scene
def late():
    import embreex
"""
    result = list(imports("radar_service.trace.ray_sampling", source, is_package=False))
    assert result == [
        "numpy", "trimesh.util", "radar_service.radar.antenna", "radar_service.numerics.frames", "radar_service.trace.embree",
        "radar_service.world.scene", "embreex",
    ]  # fmt: skip
    assert list(imports("radar_service.trace", "from . import embree", is_package=True)) == ["radar_service.trace.embree"]
