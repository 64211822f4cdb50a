"""The command `sweep`: computes scenes, parameters and seeds into one Zarr store."""

import argparse
import os
from functools import partial
from pathlib import Path

from radar_service.commands.shared_options import add_jobs, workers_of
from radar_service.processes.limits import default_memory
from radar_service.sweep.estimate import estimate
from radar_service.sweep.inputs import inputs_of
from radar_service.sweep.layout import layout_of
from radar_service.sweep.spec import json_schema as json_schema  # of `schema sweep`
from radar_service.sweep.store import SweepStore, library
from radar_service.sweep.sweep import Tally, run_sweep
from radar_service.terminal import UsageError, add_whole_number, make_folder, progress

SHOWN = 5  # failed runs whose reason is printed; the store has all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("spec", type=Path, metavar="SPEC", help="file.toml: scenes, values to vary, seeds, what is kept")
    parser.add_argument("-o", "--out", type=_store, metavar="STORE", help="folder.zarr, or an address that fsspec serves")
    add_jobs(parser)
    add_whole_number(
        parser, "--max-failures", None, 1, 10**6, metavar="N", help="end after N failed runs (default: try all)"
    )
    parser.add_argument("--dry-run", action="store_true", help="print runs, CPU hours and bytes, and do nothing")


def run(options: argparse.Namespace) -> int:
    """Runs the command, with a progress bar on a terminal; returns the exit status: 1 where runs failed.

    Raises UsageError, MissingExtra and OSError.
    """
    if options.out is None and not options.dry_run:
        raise UsageError("-o: name the store to write, as -o sweep.zarr, or give --dry-run")
    library()
    inputs = inputs_of(options.spec)
    layout = layout_of(inputs)
    if options.dry_run:
        print(estimate(inputs, layout))
        return 0
    if "://" not in options.out:
        make_folder(Path(options.out).parent)
    tally = Tally()
    shown = partial(progress, unit="runs", name=lambda outcome: outcome.job.name, remark=lambda: str(tally))
    with workers_of(options, 2 * default_memory() // options.jobs) as (executor, of_workers):
        run_sweep(inputs, layout, options.out, of_workers, executor, options.max_failures, shown, tally)
    left = len(inputs.runs) - tally.kept - tally.done - len(tally.failed)
    print(
        f"{options.out}: {tally.done} runs, {tally.kept} were there already, {len(tally.failed)} failed"
        + (f", {left} left" if left else "")
    )
    if balance := SweepStore(options.out, write=False).class_balance():
        print("cells by label: " + ", ".join(f"{name} {share:.2%}" for name, share in balance.items()))
    for number, reason in [*tally.failed.items()][:SHOWN]:
        print(f"run {number}: {reason}")
    return 1 if tally.failed else 0


def _store(text: str) -> str:
    """The address of a store: of a folder the whole path, as workers may work in another one. Raises ArgumentTypeError."""
    if not text.rstrip("/").endswith(".zarr"):
        raise argparse.ArgumentTypeError(f'"{text}" does not end in .zarr, the format that is written; give it that ending')
    return text if "://" in text else os.path.abspath(text)
