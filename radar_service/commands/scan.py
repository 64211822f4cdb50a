"""The command `scan`: computes scans into files, with a picture and their truth."""

import argparse
from collections.abc import Iterable, Iterator
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from radar_service.commands.shared_options import add_radar, add_scene, add_simulation, simulator_options
from radar_service.display.last_scan import last_scan_png
from radar_service.display.units import DEFAULT_UNIT, Unit, add_unit
from radar_service.display.video import Controls, layout
from radar_service.records import SpokeBlock
from radar_service.scans import SUFFIX, Scan, exporter, save_scans, scan_of
from radar_service.scene_file import load_scene
from radar_service.simulator import Simulator
from radar_service.terminal import (
    UsageError,
    add_overwrite,
    add_sources,
    add_whole_number,
    check_sources,
    file_ending,
    prepare,
    write_file,
)
from radar_service.truth.truth_file import truth_line, truth_lines

PICTURE_SIZE = 900  # pixels


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    add_simulation(parser)
    add_radar(parser)
    add_scene(parser)
    scan_file = partial(file_ending, suffix=(".npz", ".zarr", ".nc"))
    parser.add_argument("-o", "--out", type=scan_file, required=True, help="file.npz, .zarr or .nc to write")
    parser.add_argument(
        "--png", type=partial(file_ending, suffix=".png"), help="file.png to write: picture of the last scan"
    )
    add_unit(parser, "--png")
    add_overwrite(parser)
    add_whole_number(parser, "--scans", 1, 1, 10_000, help="revolutions (default 1)")
    parser.add_argument(
        "--truth", type=partial(file_ending, suffix=".jsonl"), help="file.jsonl to write: the truth of each beam crossing"
    )
    parser.add_argument("--radiometric", action="store_true", help="measure the power of each body too, for --truth")
    add_sources(parser, "write", " too")


def run(options: argparse.Namespace) -> int:
    """Runs the command, with a progress bar on a terminal; returns the exit status. Raises SceneError, UsageError and OSError."""
    check_sources(options, "labels", "powers", "radiometric")
    if options.radiometric and not options.truth:
        raise UsageError("--radiometric: it needs the file of --truth; add --truth FILE.jsonl, or leave --radiometric out")
    prepare((options.out, options.png, options.truth), options.overwrite)
    save = save_scans if options.out.suffix.lower() == SUFFIX else exporter(options.out)
    simulator = simulator_options(options, options.threads)(load_scene(options.scene).for_radar(options.radar))
    try:
        simulator.request_sources(options.labels, options.powers)
    except ValueError as error:
        raise UsageError(f"--{error}") from None
    azimuths = simulator.scene.radar.azimuths
    truth = [truth_line(simulator.truth_header())] if options.truth else []
    with tqdm(total=options.scans * azimuths, unit="spokes", disable=None) as bar:
        scans = []
        for _, group in groupby(_counted(simulator.blocks(scans=options.scans), bar), lambda block: block.scan):
            scans.append(scan_of(group))
            if options.truth:
                number = scans[-1].number
                truth += truth_lines(simulator.crossings(number, options.radiometric), simulator.snapshot(number))
    metadata: dict[str, Any] = {
        "name": simulator.scene.name, "seed": simulator.seed, "fidelity": simulator.fidelity.name
    }  # fmt: skip
    if options.labels or options.powers:
        names = simulator.label_names
        metadata |= {"label_numbers": np.array(list(names), dtype=np.uint32), "label_names": np.array(list(names.values()))}
    if options.truth:
        write_file(options.truth, "".join(truth))
    save(options.out, scans, metadata)
    if options.png:
        write_png(options.png, scans[-1], simulator, options.unit)
    print(f"{options.out}: {options.scans} x {azimuths} spokes of {simulator.range.size} cells")
    return 0


def write_png(path: Path, scan: Scan, simulator: Simulator, unit: Unit = DEFAULT_UNIT) -> None:
    """Writes a picture of a scan, as a display with its default controls shows it. unit: of ranges and rings."""
    rows = [(np.arange(len(scan.power)), scan.power, None)]
    pulses = simulator.scene.radar.pulses_integrated
    to = layout(simulator.range.size, float(simulator.range[0]), simulator.range_step, pulses=pulses)
    picture = last_scan_png(
        rows, len(scan.power), to, Controls(), simulator.noise_power, title=simulator.scene.name, size=PICTURE_SIZE,
        range_max=None, heading=float(scan.heading[-1]), unit=unit,
    )  # fmt: skip
    write_file(path, picture)


def _counted(blocks: Iterable[SpokeBlock], bar: "tqdm[None]") -> Iterator[SpokeBlock]:
    for block in blocks:
        bar.update(len(block))
        yield block
