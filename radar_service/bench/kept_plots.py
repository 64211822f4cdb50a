"""Plots and truth of scenarios and seeds, which are kept in a folder and shared by all trackers."""

import gzip
import hashlib
import json
import os
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from radar_service.bench.ais_reports import with_ais
from radar_service.bench.blind import FIRST_SEED
from radar_service.bench.few_tiles import has_few, prepared_together
from radar_service.bench.run import observed, simulator_of, surroundings, threshold_of
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.scan_result import ScanResult, Surroundings, TargetTruth
from radar_service.bench.trackers.callable_child import scan_of
from radar_service.engine.preparation import Prepared
from radar_service.numerics import arithmetic
from radar_service.plots import flood_remark
from radar_service.simulator import Simulator
from radar_service.strict_json import tupled
from radar_service.terminal import make_folder, progress, write_file

SCHEMA = 3
PACKAGE = Path(__file__).parents[1]
SOURCES = (".py", ".c", ".h")  # with those of the compiled kernels
NO_PART = ("service", "ports", "recording", "commands", "study", "sweep", "clients", "scenes")
OF_BENCH = ("run.py", "few_tiles.py", "plot_errors.py", "kept_plots.py", "recorded.py")  # files that have a part in it


@dataclass(frozen=True)
class ObservedRun:
    """Plots and truth of a scenario and a seed. results: without tracks; remark: on floods; around: of what tracks may be
    false."""

    results: Sequence[ScanResult]
    remark: str | None
    around: Surroundings


def observed_run(folder: Path | None, scenario: Scenario, seed: int) -> ObservedRun:
    """Returns plots and truth of a scenario and a seed, kept in the folder where they are made of the same; or makes and keeps
    them. folder: None keeps nothing. Raises SceneError and OSError."""
    path = folder and plots_path(folder, scenario, seed)
    kept = _read(path, plots_digest(scenario, seed)) if path else None
    if kept is None:
        kept = json.loads(_made(path, scenario, seed))  # the first tracker gets what the next ones get
    around = Surroundings(tuple((east, north) for east, north in kept["around"]["land"]), kept["around"]["clutter"])
    truths = (tuple(TargetTruth(**tupled(truth)) for truth in scan["truths"]) for scan in kept["scans"])
    orders = [order.model_dump() for order in scenario.order]
    results = [
        ScanResult(scan_of(scan["given"]), (), some, orders=tuple(order for order in orders if order["scan"] == number))
        for number, (scan, some) in enumerate(zip(kept["scans"], truths, strict=True))
    ]
    return ObservedRun(with_ais(results, scenario.ais, seed), kept["remark"], around)


def keep_plots(folder: Path, scenario: Scenario, seeds: Sequence[int]) -> None:
    """Makes and keeps plots and truth of some seeds together, of steady points in noise; of others nothing. Raises as
    observed_run."""
    bodies = scenario.scene.get("body", ())
    if scenario.recorded or any(body.get("shape") != "point" or body.get("swerling") for body in bodies):
        return
    simulators = [simulator_of(scenario, seed) for seed in seeds]
    if has_few(simulators[0], threshold_of(scenario.plots, simulators[0].scene)):
        for seed, shared in zip(seeds, zip(simulators, prepared_together(simulators), strict=True), strict=True):
            _made(plots_path(folder, scenario, seed), scenario, seed, shared)


def plots_path(folder: Path, scenario: Scenario, seed: int) -> Path:
    """Returns the file of plots and truth of a scenario and a seed, whose name tells no salted seed."""
    name = f"{scenario.name}-{seed}"
    if seed >= FIRST_SEED:
        name = hashlib.blake2b(name.encode(), digest_size=16).hexdigest()
    return folder / f"{name}.json.gz"


def plots_digest(scenario: Scenario, seed: int) -> str:
    """Returns a hash of all that plots and truth depend on: the scene with its files, settings, this program, the arithmetic."""
    files = named_files([scenario.scene, scenario.recorded], scenario.folder).values()
    made_of = {
        "schema": SCHEMA, "source": source_digest(), "arithmetic": arithmetic(), "scene": scenario.scene_for(seed),
        "settings": scenario.model_dump(mode="json", include={"scans", "fidelity", "radar", "plots", "plot_errors", "recorded"}),
        "targets": scenario.tracked, "files": [hashlib.blake2b(path.read_bytes()).hexdigest() for path in files],
    }  # fmt: skip
    return hashlib.blake2b(json.dumps(made_of).encode(), digest_size=16).hexdigest()


@cache
def program_version() -> str:
    """Returns the version of this program."""
    return version("radar-service")


@cache
def source_digest() -> str:
    """Returns a hash of the source of the engine, of the plot extractor, and of what feeds a tracker with their plots."""
    return _digest_of(source_files())


@cache
def bench_digest() -> str:
    """Returns a hash of the source of the bench: of its reference trackers, of scores and of events."""
    return _digest_of(_sources(PACKAGE / "bench"))


def source_files() -> list[Path]:
    """Returns the files that `source_digest` is made of."""
    return [path for path in _sources(PACKAGE) if makes_plots(path.relative_to(PACKAGE).parts)]


def _sources(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*.*") if path.suffix in SOURCES)


def _digest_of(files: Sequence[Path]) -> str:
    content = b"".join(path.relative_to(PACKAGE).as_posix().encode() + path.read_bytes() for path in files)
    return hashlib.blake2b(content, digest_size=8).hexdigest()


def makes_plots(parts: Sequence[str]) -> bool:
    """Returns whether a file of the package, given by the parts of its path, has a part in plots and truth."""
    return parts[0] not in NO_PART and (parts[0] != "bench" or parts[-1] in OF_BENCH)


def named_files(content: object, folder: Path | None) -> dict[str, Path]:
    """Returns the files of a folder that the content of a scene names, by these names: meshes, height maps, tracks."""
    return {text: path for text in _texts(content) if os.path.isfile(path := (folder or Path()) / text)}


def _texts(value: object) -> Iterator[str]:
    """All texts of nested tables."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping | list | tuple):
        for part in value.values() if isinstance(value, Mapping) else value:
            yield from _texts(part)


def _made(path: Path | None, scenario: Scenario, seed: int, shared: tuple[Simulator, Prepared] | None = None) -> str:
    """The text of a file of plots, which is written where it has a path. shared: with other seeds."""
    name = f"{scenario.name}, seed {seed}"

    def tell(flood: str) -> None:
        if seed == 0:  # the report has a remark on all seeds
            print(f"{name}: {flood}", file=sys.stderr, flush=True)

    scans = observed(scenario, seed, tell, shared)
    results = list(progress(scans, scenario.scans, "scans", lambda _: f"{name}: plots", within=True))
    remark = flood_remark([result.flood for result in results if result.flood], len(results))
    kept = {"digest": plots_digest(scenario, seed), "scans": [asdict(replace(result, flood=None)) for result in results]}
    text = json.dumps({**kept, "around": asdict(surroundings(scenario)), "remark": remark}, allow_nan=False)
    if path:
        make_folder(path.parent)
        write_file(path, gzip.compress(text.encode(), compresslevel=6))
    return text


def _read(path: Path, digest: str) -> dict[str, Any] | None:
    """The content of a file that is whole and has this digest; None otherwise."""
    try:
        kept: dict[str, Any] = json.loads(gzip.decompress(path.read_bytes()))
        return kept if kept["digest"] == digest else None
    except (OSError, EOFError, zlib.error, ValueError, KeyError, TypeError):
        return None
