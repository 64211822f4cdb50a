"""The house keeps its order: imports point one way, each heavy library has one home, names say what a thing is.

The rules are those of the design's "house" section: scene <- trace <- echo <- receive <- display <- stream.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STAGES = ("scene", "trace", "echo", "receive", "display", "stream")
SHARED = ("constants", "frames", "packaged", "random", "records", "fidelity", "threads")  # below every stage
WIRING = (
    "simulate",
    "documented",
    "corrected",
    "plan",
    "planning",
    "truth",
    "study",
    "__init__",
)  # above every stage but stream
CLIENT_MAY = ("radar_service.stream.wire", "radar_service.display")
HOMES = {
    "trimesh": ("radar_service.scene",),
    "pyproj": ("radar_service.scene",),
    "embreex": ("radar_service.trace.embree",),
    "fastapi": ("radar_service.stream",),
    "starlette": ("radar_service.stream",),
    "uvicorn": ("radar_service.stream", "radar_service.__main__"),
    "pydantic": (
        "radar_service.scene.fields",
        "radar_service.scene.interference_model",
        "radar_service.scene.model",
        "radar_service.scene.radar_model",
        "radar_service.scene.source",
        "radar_service.scene.faults",
        "radar_service.stream",
    ),
    "pydantic_core": ("radar_service.scene.faults",),
    "prometheus_client": ("radar_service.stream.metrics",),
    "zstandard": ("radar_service.stream.wire",),
    "msgpack": ("radar_service.stream.wire",),
    "websockets": ("clients.ppi",),
    "PIL": ("radar_service.scene", "radar_service.display", "radar_service.study"),
}
NAMELESS = ("util", "utils", "helper", "helpers", "manager", "managers", "base", "common", "misc")


def within(module: str, *homes: str) -> bool:
    """Whether a module is one of `homes` or lies inside one."""
    return any(module == home or module.startswith(f"{home}.") for home in homes)


def room(module: str) -> str:
    """The part of radar_service that a module belongs to: radar_service.echo.antenna is in echo."""
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
    if here in STAGES:
        allowed = (*STAGES[: STAGES.index(here) + 1], *SHARED)
    elif here in SHARED:
        allowed = SHARED
    elif here in WIRING:
        allowed = (*STAGES[:-1], *SHARED, *WIRING)
    else:
        return f"{importer}: the house has no place for it; the parts are {', '.join((*STAGES, *SHARED, *WIRING))}"
    if there in allowed:
        return None
    return f"{importer} imports {imported}: {here} may use {', '.join(allowed)} and nothing above"


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


@pytest.mark.parametrize("module", HOUSE)
def test_imports_point_one_way(module: str) -> None:
    file = HOUSE[module]
    found = imports(module, file.read_text(), file.name == "__init__.py")
    faults = [said for said in (fault(module, imported) for imported in found) if said]
    assert not faults, f"{file.relative_to(ROOT)}: " + "; ".join(faults)


@pytest.mark.parametrize("module", HOUSE)
def test_names_say_what_a_thing_is(module: str) -> None:
    empty = [part for part in module.split(".") if part in NAMELESS]
    assert not empty, f"{HOUSE[module].relative_to(ROOT)}: {empty[0]} says nothing about the radar; name it for what it does"


def test_the_whole_house_is_looked_at() -> None:
    for stage in STAGES:
        assert f"radar_service.{stage}" in HOUSE, f"radar_service/{stage}: a stage of the house has no folder"
    assert {"radar_service.__main__", "radar_service.stream.wire", "clients.ppi.client"} <= set(HOUSE)


@pytest.mark.parametrize(
    ("importer", "imported", "rule"),
    [
        ("radar_service.scene.load", "radar_service.trace.embree", "nothing above"),
        ("radar_service.echo.antenna", "radar_service.receive.beam", "nothing above"),
        ("radar_service.display.ppi", "radar_service.stream.wire", "nothing above"),
        ("radar_service.receive.beam", "radar_service.simulate", "nothing above"),
        ("radar_service.stream.app", "radar_service.simulate", "nothing above"),
        ("radar_service.stream.app", "radar_service", "nothing above"),
        ("radar_service.records", "radar_service.scene.world", "nothing above"),
        ("radar_service.simulate", "radar_service.stream.hub", "nothing above"),
        ("radar_service.simulate", "radar_service.__main__", "nothing above"),
        ("radar_service.study.chart", "radar_service.stream.hub", "nothing above"),
        ("radar_service", "radar_service.stream", "nothing above"),
        ("radar_service.glue", "radar_service.frames", "no place"),
        ("radar_service.stream.app", "clients.ppi", "does not know its clients"),
        ("clients.ppi.client", "radar_service.stream.hub", "clients use"),
        ("clients.ppi.client", "radar_service.records", "clients use"),
        ("clients.ppi.client", "radar_service.displays", "clients use"),
        ("radar_service.echo.optics", "trimesh", "trimesh lives in"),
        ("radar_service.trace.rays", "embreex.rtcore_scene", "embreex lives in"),
        ("radar_service.scene.world", "pydantic", "pydantic lives in"),
        ("radar_service.simulate", "uvicorn", "uvicorn lives in"),
        ("clients.ppi.client", "fastapi", "fastapi lives in"),
    ],
)
def test_rules_can_be_broken(importer: str, imported: str, rule: str) -> None:
    said = fault(importer, imported)
    assert said is not None and rule in said and said.startswith(importer)


@pytest.mark.parametrize(
    ("importer", "imported"),
    [
        ("radar_service.echo.antenna", "radar_service.scene.world"),
        ("radar_service.echo.antenna", "radar_service.echo.propagation"),
        ("radar_service.scene.load", "radar_service.frames"),
        ("radar_service.simulate", "radar_service.display.psf"),
        ("radar_service.__main__", "radar_service.stream.app"),
        ("clients.ppi.client", "radar_service.stream.wire"),
        ("clients.ppi.scans", "radar_service.display.ppi"),
        ("radar_service.trace.embree", "embreex.rtcore_scene"),
        ("radar_service.echo.antenna", "scipy.special"),
    ],
)
def test_rules_let_pass_what_they_should(importer: str, imported: str) -> None:
    assert fault(importer, imported) is None


def test_imports_are_found_in_every_form() -> None:
    source = """
import numpy as np, trimesh.util
from radar_service.stream import wire
from radar_service.frames import direction
from . import embree
from ..scene.world import Mesh
def late():
    import embreex
"""
    found = list(imports("radar_service.trace.rays", source, is_package=False))
    assert found == [
        "numpy", "trimesh.util", "radar_service.stream.wire", "radar_service.frames", "radar_service.trace.embree",
        "radar_service.scene.world", "embreex",
    ]  # fmt: skip
    assert list(imports("radar_service.trace", "from . import embree", is_package=True)) == ["radar_service.trace.embree"]
