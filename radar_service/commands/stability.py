"""The command `stability`: finds where each method fails, and writes a report."""

import argparse
from pathlib import Path

from tqdm import tqdm

from radar_service.terminal import add_whole_number, make_folder


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for stability.html and stability.json")
    add_whole_number(parser, "--fine", 1, 1, 20, help="times as many samples")


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises MissingExtra and OSError."""
    from radar_service.study.stability import STUDIES  # here: they need an extra, and `--help` does not
    from radar_service.study.stability.report import write_report

    make_folder(options.out)
    findings = [study(options.fine) for study in tqdm(STUDIES, unit="regions", disable=None)]
    write_report(options.out, findings)
    print(f"{options.out / 'stability.html'}: {len(findings)} regions")
    return 0
