"""The tables of docs/ that come from code: `python -m tests.reference.docs_tables` writes them anew; tests/test_docs.py compares.

Each table stands between `<!-- table: NAME -->` and `<!-- end -->`. What lies between the two lines is replaced.
"""

import ast
import inspect
import math
import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

from radar_service.numerics.constants import NAUTICAL_MILE
from radar_service.ports.app import create_app
from radar_service.radar.sets import radar_sets
from radar_service.records.fidelity import PRESETS
from radar_service.scene_file.model.body import KINDS, OWN_KEYS, BodyModel
from radar_service.scene_file.model.scene import scene_model
from radar_service.service.radio.radio_state import Event, State
from radar_service.world.body import GROUND_ROUGHNESS, MATERIALS, VESSEL_MATERIALS, power_reflectivity

DOCS = Path(__file__).parents[2] / "docs"
BLOCK = re.compile(r"(<!-- table: ([a-z-]+) -->\n).*?(<!-- end -->)", flags=re.S)
UNITS = {  # by the longest ending of a key
    "_percent": "%", "_per_s": "1/s", "_deg_s": "degrees/s", "_dbm": "dBm",
    "_mm_h": "mm/h", "_db_per_km": "dB/km", "_hz": "Hz", "_dbsm": "dBsm", "_dbi": "dBi", "_db": "dB", "_deg": "degrees",
    "_kn": "knots", "_m": "m", "_s": "s", "_w": "W", "rpm": "rev/min",
}  # fmt: skip
METHODS = ("get", "post", "put", "patch", "delete")

Schema = dict[str, Any]


def table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """A Markdown table; a bar inside a cell is escaped."""
    lines = [head, tuple("---" for _ in head), *(tuple(cell.replace("|", r"\|") for cell in row) for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def unit(key: str) -> str:
    """The unit that a key's ending names, empty for none."""
    return next((name for ending, name in UNITS.items() if key.endswith(ending)), "")


def allowed(schema: Schema) -> str:
    """What a property of the scene's JSON Schema may be, in words."""
    if "anyOf" in schema or "oneOf" in schema:
        forms = schema.get("anyOf", schema.get("oneOf"))
        return " or ".join(allowed(each) for each in forms if each.get("type") != "null")
    if "$ref" in schema:
        return f"table {schema['$ref'].rsplit('/', 1)[1].removesuffix('Model')}"
    if "enum" in schema or "const" in schema:
        return ", ".join(f"`{value}`" for value in schema.get("enum", [schema.get("const")]))
    return {"boolean": lambda _: "true, false", "array": _array, "string": _text}.get(schema["type"], _number)(schema)


def _text(schema: Schema) -> str:
    return f"text, at most {schema['maxLength']} characters" if "maxLength" in schema else "text"


def _array(schema: Schema) -> str:
    if "prefixItems" in schema:
        return f"({'; '.join(allowed(each) for each in schema['prefixItems'])})"
    maximum = f", at most {schema['maxItems']}" if "maxItems" in schema else ""
    return f"list of {allowed(schema['items'])}{maximum}"


def _number(schema: Schema) -> str:
    kind = "whole" if schema["type"] == "integer" else ""
    low, high = schema.get("minimum", schema.get("exclusiveMinimum")), schema.get("maximum")
    if low is None or high is None:
        return kind or "number"
    return f"{kind and f'{kind}, '}{'above ' if 'exclusiveMinimum' in schema else ''}{plain(low)} to {plain(high)}"


def plain(value: float) -> str:
    """A number as a person writes it: 5000, 0.05, 2e9."""
    short, exact = f"{value:g}", f"{value:.10g}"
    text = short if abs(value) >= 1e6 and float(short) == value else exact
    return re.sub(r"e([+-])0*", lambda result: "e" + result[1].replace("+", ""), text)


def default(key: str, schema: Schema, required: list[str]) -> str:
    """The default of a property as a scene file would write it."""
    if key in required:
        return "required"
    value = schema.get("default")
    if value is None or isinstance(value, dict):
        return "none" if value is None else "its defaults"
    if isinstance(value, bool | list | tuple):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"`{plain(value)}`"


@cache
def scene_schema() -> Schema:
    """The JSON schema of scene files."""
    return scene_model().model_json_schema()


def section(name: str, beyond: str = "", keys: Collection[str] = ()) -> str:
    """The keys of one table of the scene file, but for those that the table `beyond` has alike; only `keys` if there are any."""
    whole = scene_schema()
    model: Schema = whole if name == "SceneModel" else whole["$defs"][name]
    required = model.get("required", [])
    known = whole["$defs"][beyond]["properties"] if beyond else {}
    rows = [
        (f"`{key}`", unit(key), allowed(schema), default(key, schema, required), schema.get("description", ""))
        for key, schema in model["properties"].items()
        if known.get(key) != schema and (not keys or key in keys)
    ]
    return table(("key", "unit", "allowed", "default", "remarks"), rows)


def rest() -> str:
    """Every path of the OpenAPI document, and the first sentence on it."""
    paths = create_app([]).openapi()["paths"]
    rows = [
        (method.upper(), f"`{path}`", routes[method]["description"].split("\n")[0])
        for path, routes in paths.items()
        for method in METHODS
        if method in routes
    ]
    return table(("method", "path", "what it does"), rows)


def presets() -> str:
    """The settings of each preset."""
    names = [name for name in PRESETS if name != "documented"]
    settings = [key for key in vars(PRESETS["balanced"]) if key not in ("name", "engine", "tracer", "sampler", "error_db")]
    rows = [(f"`{key}`", *(f"{getattr(PRESETS[name], key):g}" for name in names)) for key in settings]
    return table(("setting", *(f"`{name}`" for name in names)), rows)


def materials() -> str:
    """Every material, how it scatters by default, its gamma, the power that it reflects, and how rough it is as ground."""
    ground = {name: f"{height:g} m" for name, height in GROUND_ROUGHNESS.items()} | dict.fromkeys(VESSEL_MATERIALS, "")
    rows = [
        (
            f"`{name}`",
            made.scattering,
            f"{db(made.gamma)} dB",
            f"{db(power_reflectivity(name))} dB",
            ground.get(name, "none"),
        )
        for name, made in MATERIALS.items()
    ]
    return table(("material", "scattering", "gamma", "power reflectivity", "ground"), rows)


def sets() -> str:
    """The sets that are sold, their rows by range scale, and the source of each number."""
    rows = []
    first: dict[str, str] = {}
    for name, each in radar_sets().items():
        scales: dict[str, list[str]] = {}
        for length, keys in each.scales.items():
            scales.setdefault(_pulse(keys), []).append(f"{length / NAUTICAL_MILE:g}")
        about = "; ".join(f"{', '.join(nm)} NM: {pulse}" for pulse, nm in scales.items())
        same = first.setdefault(about, name)
        sources = [f"{keys}: {text}" for keys, text in each.sources.items()]
        rows.append((f"`{name}`", each.of, about if same == name else f"as `{same}`", "; ".join(sources)))
    return table(("set", "of what", "by range scale", "sources"), rows)


def _pulse(keys: Mapping[str, Any]) -> str:
    """What a set transmits at a scale, in words; the band of a chirp follows its samples."""
    pulses = [f"{each['pulse_s'] * 1e6:g} us" for each in keys.get("pulses", [keys])]
    return " and ".join(pulses) + (f", {keys['prf_hz']} Hz" if "prf_hz" in keys else "")


def transmitter_states() -> str:
    """The states of a transmitter."""
    return table(("state", "the transmitter"), [(f"`{state.name}`", state.value) for state in State])


def radio_events() -> str:
    """What tells a radar's state of the world."""
    events = get_args(Event)
    return table(("event", "which means"), [(f"`{each.__name__}`", each.__doc__.split("\n\n")[0]) for each in events])


def rooms() -> str:
    """The rooms of the package, upward, and what the first sentence of each, up to a semicolon, says that it holds."""
    package = DOCS.parent / "radar_service"
    rules = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
    names = rules[0]["layers"][::-1]
    names.insert(names.index("service"), "__init__")  # no layer, being the package itself
    rows = []
    for name in names:
        file = package / f"{name}.py" if (package / f"{name}.py").exists() else package / name / "__init__.py"
        text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
        rows.append(
            (
                f"`{name}.py`" if file.parent == package else f"`{name}/`",
                re.split(r"[.;](?= |$)", text.replace("\n", " "))[0],
            )
        )
    return table(("folder or file", "holds"), rows)


PUBLIC = (
    "radar_service",
    "radar_service.effects",
    "radar_service.scans",
    "radar_service.recording",
    "radar_service.plots",
    "radar_service.bench",
    "radar_service.wire",
)
INTERFACES = (
    "radar_service.radar.antenna:AntennaPattern", "radar_service.scattering.model:ScatteringModel",
    "radar_service.plots.thresholds:Threshold", "radar_service.scene_file.readers.file_format:MeshReader",
    "radar_service.scene_file.readers.file_format:BodyFile",
    "radar_service.stages.effect:Effect", "radar_service.stages.effect:EffectTruth", "radar_service.stages.stage:Stage",
    "radar_service.spoke_source:SpokeSource", "radar_service.spoke_source:Commanded",
    "radar_service.spoke_source:TellsSources",
    "radar_service.service.scene_request:Spared",
    "radar_service.service.spokes:SpokeSink", "radar_service.service.codecs.codec:Codec",
    "radar_service.ports.registry:PortPackage", "radar_service.ports.port:Port",
    "radar_service.bench.trackers.tracker:Tracker", "radar_service.batch.jobs:Executor",
    "radar_service.commands.command_line:CommandModule",
)  # fmt: skip


def public() -> str:
    """The public packages and their names."""
    rows = [(f"`{name}`", ", ".join(f"`{each}`" for each in import_module(name).__all__)) for name in PUBLIC]
    return table(("package", "names"), rows)


def interfaces() -> str:
    """The interfaces that others implement, with their members."""
    rows = []
    for name in INTERFACES:
        module, _, kind = name.partition(":")
        interface = getattr(import_module(module), kind)
        members = [name for name in {**vars(interface), **interface.__annotations__} if not name.startswith("_")]
        path = module.replace(".", "/") + ".py"
        rows.append((f"`{kind}`", first_paragraph(interface), ", ".join(f"`{m}`" for m in members), f"`{path}`"))
    return table(("interface", "what it is", "members", "in"), rows)


@cache
def sections() -> dict[str, list[list[str]]]:
    """What is promised, by section: a sentence, then the tests that check it."""
    return tomllib.loads(Path(__file__).with_name("promises.toml").read_text(encoding="utf-8"))


def promises(section: str) -> str:
    """The promises of a section, with links to the tests that check each."""
    links = [
        (row[0], ", ".join(f"[{test.rsplit('/', 1)[-1]}](../tests/{test}.py)" for test in row[1:]))
        for row in sections()[section]
    ]
    return table(("promise", "tests"), links)


def first_paragraph(of: object) -> str:
    """The first paragraph of a docstring, on one line."""
    return (inspect.getdoc(of) or "").split("\n\n")[0].replace("\n", " ")


def db(ratio: float) -> str:
    """A power ratio in dB, to a tenth."""
    return f"{10.0 * math.log10(ratio) + 0.0:.3g}"


TABLES: dict[str, Callable[[], str]] = {
    "scene": lambda: section("SceneModel"),
    "origin": lambda: section("OriginModel"),
    "radar": lambda: section("RadarModel"),
    "named-radar": lambda: section("NamedRadarModel", beyond="RadarModel"),
    "platform": lambda: section("PlatformModel"),
    "pulse": lambda: section("PulseModel", beyond="RadarModel"),
    "structure": lambda: section("StructureModel"),
    "multiple-echoes": lambda: section("MultipleEchoesModel"),
    "own-ship": lambda: section("OwnShipModel"),
    "environment": lambda: section("EnvironmentModel"),
    "body": lambda: section("ShapeBodyModel", beyond="OwnShipModel", keys=BodyModel.model_fields),
    **{f"body-{kind}": partial(section, model.__name__, keys=OWN_KEYS[kind]) for kind, model in KINDS.items()},
    "waypoint": lambda: section("WaypointModel"),
    "manoeuvre": lambda: section("ManoeuvreModel"),
    "seaway": lambda: section("SeawayModel"),
    "hull": lambda: section("HullModel"),
    "plating": lambda: section("PlatingModel"),
    "fading": lambda: section("FadingModel"),
    "racon": lambda: section("RaconModel"),
    "sart": lambda: section("SartModel", beyond="RaconModel"),
    "interference": lambda: section("InterferenceModel"),
    "rain-cell": lambda: section("RainCellModel"),
    "transponder": lambda: section("TransponderModel"),
    "ais": lambda: section("AisModel"),
    "errors": lambda: section("ErrorsModel"),
    **{f"errors-{name}": partial(section, f"{name.capitalize()}ErrorsModel") for name in ("gyro", "antenna", "feed")},
    **{
        f"errors-{name}": partial(section, f"{name.capitalize()}ErrorsModel", beyond="GyroErrorsModel")
        for name in ("log", "position")
    },
    "materials": materials,
    "sets": sets,
    "presets": presets,
    "rest": rest,
    "public": public,
    "interfaces": interfaces,
    "rooms": rooms,
    "transmitter-states": transmitter_states,
    **{f"promises-{name}": partial(promises, name) for name in sections()},
    "radio-events": radio_events,
}


def write_measured(name: str, rows: str, page: str = "accuracy") -> None:
    """Writes what a command has measured into a page, between `<!-- measured: NAME -->` and `<!-- end -->`."""
    document = DOCS / f"{page}.md"
    block = re.compile(rf"(<!-- measured: {name} -->\n).*?(<!-- end -->)", flags=re.S)
    text = document.read_text(encoding="utf-8")
    document.write_text(block.sub(lambda result: result[1] + rows + result[2], text), encoding="utf-8")


def renewed(text: str) -> str:
    """A document with each of its tables as the code has them now. Raises KeyError for a table of another name."""
    return BLOCK.sub(lambda result: result[1] + TABLES[result[2]]() + result[3], text)


if __name__ == "__main__":
    for document in sorted(DOCS.rglob("*.md")):
        document.write_text(renewed(document.read_text(encoding="utf-8")), encoding="utf-8")
