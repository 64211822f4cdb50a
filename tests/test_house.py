"""The house keeps its order: imports point one way, and each heavy library has one home (docs/code-map.md)."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
GROUND = ("numerics", "records", "strict_json", "packaged", "terminal")
ROOMS = (
    "radar", "scene", "trace", "propagation", "scattering", "echo", "receive", "clutter", "engine", "sources", "plan",
)  # fmt: skip  # upward
ABOVE = (*GROUND, *ROOMS, "truth", "scans", "spoke_source", "simulator", "display")  # what rooms above the simulator may use
BELOW: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(GROUND, GROUND),
    **{room: (*GROUND, *ROOMS[: i + 1]) for i, room in enumerate(ROOMS)},
    "display": (*GROUND, "radar", "scene", "display"),
    "scans": (*GROUND, "radar", "display", "scans"),
    "truth": (*GROUND, *ROOMS[: ROOMS.index("echo") + 1]),
    "errors": (*GROUND, "radar", "scene", "errors"),
    "simulation": (*GROUND, *ROOMS, "scans", "truth", "errors"),
    "spoke_source": (*GROUND, "radar", "scene"),
    "simulator": (*GROUND, *ROOMS, "scans", "truth", "errors", "simulation", "spoke_source"),
    "stream": (*GROUND, "radar", "scene", "receive", "display", "errors", "spoke_source", "stream"),
    "plots": (*GROUND, *ROOMS[: ROOMS.index("sources") + 1], "display", "scans", "truth", "simulator", "plots"),
    "tracking": (*GROUND, *ROOMS[: ROOMS.index("sources") + 1], "display", "scans", "truth", "simulator", "plots"),
    "recording": (*ABOVE, "stream", "recording"),
    "ports": (*ABOVE, "stream", "recording", "ports"),
    "radar_feed": (*ABOVE, "stream"),
    "pytest_plugin": ("radar_feed",),
    "study": (*ABOVE, "study"),
    "commands": (*ABOVE, "stream", "recording", "ports", "plots", "tracking", "commands", "__init__"),
    "__init__": (*GROUND, "scene", "scans", "simulator"),
}
STREAM_PARTS = ("processes", "codecs", "fanout", "radio", "ports", "http")  # of radar_service.stream, upward
CLIENT_MAY = (
    "radar_service.stream.codecs.native",
    "radar_service.display",
    "radar_service.scans.file",
    "radar_service.terminal.output_files",
)
HOMES = {
    "trimesh": ("radar_service.scene.files",),
    "pyproj": ("radar_service.scene",),
    "embreex": ("radar_service.trace.embree",),
    "fastapi": ("radar_service.ports", "radar_service.stream.ports", "radar_service.stream.http"),
    "starlette": ("radar_service.ports", "radar_service.stream.ports", "radar_service.stream.http"),
    "uvicorn": ("radar_service.stream.http", "radar_service.__main__"),
    "pydantic": (
        "radar_service.scene.environment_model",
        "radar_service.scene.errors_model",
        "radar_service.scene.fields",
        "radar_service.scene.files",
        "radar_service.scene.interference_model",
        "radar_service.scene.manoeuvre_model",
        "radar_service.scene.pulse_model",
        "radar_service.scene.model",
        "radar_service.scene.platform_model",
        "radar_service.scene.presence_model",
        "radar_service.scene.radar_model",
        "radar_service.scene.sway_model",
        "radar_service.scene.validation_messages",
        "radar_service.stream",
        "radar_service.tracking.scenario",
    ),
    "pydantic_core": ("radar_service.scene.validation_messages",),
    "prometheus_client": ("radar_service.stream",),
    "zstandard": ("radar_service.stream.codecs.native", "radar_service.recording.chunk_table"),
    "msgpack": ("radar_service.stream.codecs.native",),
    "websockets": ("clients.ppi", "radar_service.radar_feed", "radar_service.tracking.websocket_tracker"),
    "PIL": ("radar_service.scene", "radar_service.display", "radar_service.study"),
    "stonesoup": ("radar_service.tracking",),
    "matplotlib": (
        "radar_service.tracking.report",
        "radar_service.plots.picture",
        "radar_service.tracking.detection_report",
        "radar_service.scans.scan",
        "radar_service.study",
    ),
    "threadpoolctl": ("radar_service.numerics.parallel",),
    "xarray": ("radar_service.scans.scan", "radar_service.scans.dataset"),
    "zarr": ("radar_service.scans.dataset",),
    "pytest": ("radar_service.pytest_plugin",),
    "mcap": ("radar_service.recording.mcap_library",),
}


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
    if within(importer, "radar_service.scene") and within(imported, "radar_service.scene.files"):
        if not within(importer, "radar_service.scene.files", "radar_service.scene.load"):
            return f"{importer} imports {imported}: records of a scene do not read files"
    if here == there == "stream":
        return stream_fault(importer, imported)
    if there in (*BELOW[here], here):
        return None
    return f"{importer} imports {imported}: {here} may use {', '.join(BELOW[here])} and nothing above"


def stream_fault(importer: str, imported: str) -> str | None:
    """The same, between the parts of radar_service.stream. Modules beside the parts are below all of them, but for `serve`."""
    parts = [module.split(".")[2] if module.count(".") > 2 else "" for module in (importer, imported)]
    if importer.endswith(".serve") or not parts[1]:
        return None
    if parts[0] and STREAM_PARTS.index(parts[1]) <= STREAM_PARTS.index(parts[0]):
        return None
    here = parts[0] or importer
    return f"{importer} imports {imported}: in stream, {here} may use no part above it ({' < '.join(STREAM_PARTS)})"


def modules(*packages: str) -> dict[str, Path]:
    """Every module of some packages, and its file."""
    files = [file for package in packages for file in sorted((ROOT / package).rglob("*.py"))]
    return {".".join(f.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): f for f in files}


HOUSE = modules("radar_service", "clients", "scenes")


def imports(module: str, source: str, is_package: bool) -> Iterator[str]:
    """Full names of what a module imports, wherever in it; `from package import module` names the module."""
    for node in ast.walk(ast.parse(source)):
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
    for name in ROOMS:
        assert f"radar_service.{name}" in HOUSE, f"radar_service/{name}: a room of the house has no folder"
    assert {"radar_service.__main__", "radar_service.stream.codecs.native.wire", "clients.ppi.client"} <= set(HOUSE)


@pytest.mark.parametrize(
    ("importer", "imported", "rule"),
    [
        ("radar_service.scene.world", "radar_service.trace.embree", "nothing above"),
        ("radar_service.scene.world", "radar_service.scene.files.mesh_file", "do not read files"),
        ("radar_service.radar.antenna", "radar_service.scene.world", "nothing above"),
        ("radar_service.echo.moving", "radar_service.receive.beam", "nothing above"),
        ("radar_service.display.ppi", "radar_service.stream.codecs.native.wire", "nothing above"),
        ("radar_service.receive.beam", "radar_service.simulator", "nothing above"),
        ("radar_service.engine.pipeline", "radar_service.plan.culling", "nothing above"),
        ("radar_service.plan.realtime", "radar_service.simulator", "nothing above"),
        ("radar_service.stream.http.app", "radar_service.simulator", "nothing above"),
        ("radar_service.stream.http.app", "radar_service", "nothing above"),
        ("radar_service.stream.fanout.hub", "radar_service.stream.http.app", "no part above"),
        ("radar_service.stream.spokes", "radar_service.stream.fanout.hub", "no part above"),
        ("radar_service.records.spokes", "radar_service.scene.world", "nothing above"),
        ("radar_service.simulator", "radar_service.stream.fanout.hub", "nothing above"),
        ("radar_service.simulator", "radar_service.__main__", "nothing above"),
        ("radar_service.study.chart", "radar_service.stream.fanout.hub", "nothing above"),
        ("radar_service", "radar_service.stream", "nothing above"),
        ("radar_service.glue", "radar_service.numerics.frames", "no place"),
        ("radar_service.stream.http.app", "clients.ppi", "does not know its clients"),
        ("radar_service.stream.radio.station", "radar_service.recording.recording", "nothing above"),
        ("radar_service.recording.recording", "mcap.reader", "mcap lives in"),
        ("clients.ppi.client", "radar_service.stream.fanout.hub", "clients use"),
        ("clients.ppi.client", "radar_service.records.spokes", "clients use"),
        ("clients.ppi.client", "radar_service.displays", "clients use"),
        ("radar_service.scattering.rays", "trimesh", "trimesh lives in"),
        ("radar_service.trace.ray_sampling", "embreex.rtcore_scene", "embreex lives in"),
        ("radar_service.scene.world", "pydantic", "pydantic lives in"),
        ("radar_service.scene.body", "radar_service.scene.files.mesh", "do not read files"),
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
        ("radar_service.echo.moving", "radar_service.scene.world"),
        ("radar_service.echo.moving", "radar_service.propagation.multipath"),
        ("radar_service.scene.load", "radar_service.scene.files.scene_file"),
        ("radar_service.simulator", "radar_service.engine.pipeline"),
        ("radar_service.__main__", "radar_service.stream.http.app"),
        ("clients.ppi.client", "radar_service.stream.codecs.native.wire"),
        ("clients.ppi.scans", "radar_service.display.ppi"),
        ("radar_service.trace.embree", "embreex.rtcore_scene"),
        ("radar_service.radar.antenna", "scipy.special"),
    ],
)
def test_rules_allow_the_rest(importer: str, imported: str) -> None:
    assert fault(importer, imported) is None


def test_the_table_of_rooms_has_each_once_below_all_that_it_imports() -> None:
    text = (ROOT / "docs/code-map.md").read_text()
    table = re.findall(r"^\| `([a-z_]+)(?:/|\.py)` \|", text, re.MULTILINE)
    assert sorted(table) == sorted({*BELOW, "__main__"})
    inner = {importer: file for importer, file in HOUSE.items() if within(importer, "radar_service")}
    for importer, file in inner.items():
        for imported in imports(importer, file.read_text(), file.name == "__init__.py"):
            if within(imported, "radar_service"):
                assert table.index(room(imported)) <= table.index(room(importer)), f"{importer} imports {imported}"


def test_imports_are_found_in_every_form() -> None:
    source = """
import numpy as np, trimesh.util
from radar_service.radar import antenna
from radar_service.numerics.frames import direction
from . import embree
from ..scene.world import Scene
def late():
    import embreex
"""
    result = list(imports("radar_service.trace.ray_sampling", source, is_package=False))
    assert result == [
        "numpy", "trimesh.util", "radar_service.radar.antenna", "radar_service.numerics.frames", "radar_service.trace.embree",
        "radar_service.scene.world", "embreex",
    ]  # fmt: skip
    assert list(imports("radar_service.trace", "from . import embree", is_package=True)) == ["radar_service.trace.embree"]
