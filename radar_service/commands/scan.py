"""The command `scan`: computes scans, and writes them, a picture and their truth into files."""

import argparse
import contextlib
from collections.abc import Callable, Iterable, Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from radar_service.display.last_scan import last_scan_png
from radar_service.display.units import DEFAULT_UNIT, Unit
from radar_service.display.video import Controls, layout
from radar_service.records.spokes import SpokeBlock
from radar_service.scans.dataset import exporter
from radar_service.scans.file import SUFFIX
from radar_service.scans.scan import Scan, save_scans, scan_of
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from radar_service.terminal.output_files import prepare
from radar_service.truth.truth_file import TruthFile
from radar_service.world.scene import Scene

PICTURE_SIZE = 900  # pixels


class SourcesError(ValueError):
    """Sources that the scans cannot tell of. The text names the option and says why."""


def scan(options: argparse.Namespace, make: Callable[[Scene], Simulator]) -> int:
    """Computes scans, with a progress bar on a terminal; returns the exit status. Raises SceneError, SourcesError and OSError."""
    prepare((options.out, options.png, options.truth), options.overwrite)
    save = save_scans if options.out.suffix.lower() == SUFFIX else exporter(options.out)
    simulator = make(load_scene(options.scene).for_radar(options.radar))
    try:
        simulator.request_sources(options.labels, options.powers)
    except ValueError as error:
        raise SourcesError(f"--{error}") from None
    azimuths = simulator.scene.radar.azimuths
    with tqdm(total=options.scans * azimuths, unit="spokes", disable=None) as bar, _truth_noted(options, simulator) as note:
        scans = []
        for _, group in groupby(_counted(simulator.blocks(scans=options.scans), bar), lambda block: block.scan):
            scans.append(scan_of(group))
            note(scans[-1].number)
    metadata: dict[str, Any] = {
        "name": simulator.scene.name, "seed": simulator.seed, "fidelity": simulator.fidelity.name
    }  # fmt: skip
    if options.labels or options.powers:
        names = simulator.label_names
        metadata |= {"label_numbers": np.array(list(names), dtype=np.uint32), "label_names": np.array(list(names.values()))}
    save(options.out, scans, metadata)
    if options.png:
        write_png(options.png, scans[-1], simulator, options.unit)
    print(f"{options.out}: {options.scans} x {azimuths} spokes of {simulator.range.size} cells")
    return 0


def write_png(path: Path, scan: Scan, simulator: Simulator, unit: Unit = DEFAULT_UNIT) -> None:
    """Writes a picture of a scan, as a display with its default controls shows it. unit: of ranges and rings."""
    rows = [(np.arange(len(scan.power)), scan.power, None)]
    to = layout(simulator.range.size, float(simulator.range[0]), simulator.range_step)
    path.write_bytes(
        last_scan_png(
            rows, len(scan.power), to, Controls(), simulator.noise_power, title=simulator.scene.name, size=PICTURE_SIZE,
            range_max=None, heading=float(scan.heading[-1]), unit=unit,
        )
    )  # fmt: skip


@contextlib.contextmanager
def _truth_noted(options: argparse.Namespace, simulator: Simulator) -> Iterator[Callable[[int], None]]:
    """A function that writes the truth of a scan, where the options ask for it."""
    if not options.truth:
        yield lambda number: None
        return
    with TruthFile(options.truth, simulator.truth_header()) as file:
        yield lambda number: file.write(simulator.crossings(number, options.radiometric), simulator.snapshot(number))


def _counted(blocks: Iterable[SpokeBlock], bar: "tqdm[None]") -> Iterator[SpokeBlock]:
    for block in blocks:
        bar.update(len(block))
        yield block
