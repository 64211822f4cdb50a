"""The command `believed`: holds the simulator against published figures."""

import argparse
from pathlib import Path

from radar_service.terminal import UsageError, make_folder, progress, write_file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("rows", nargs="*", metavar="ROW", help="rows of the table, as N01 (default all, in some 15 minutes)")
    out = "folder for the page, its picture, and the scenes of each row (default believed)"
    parser.add_argument("-o", "--out", type=Path, default=Path("believed"), help=out)


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status: 1 where a row that was asked for is outside.

    Raises UsageError, MissingExtra, SceneError and OSError.
    """
    from radar_service.believed.verdicts import PAGE, TableError, chosen_rows, measured, page, row_text, write_picture

    try:
        rows = chosen_rows(options.rows)
    except TableError as error:
        raise UsageError(str(error)) from None
    make_folder(options.out)
    verdicts = list(
        progress(
            measured(rows, options.out), len(rows), "rows", lambda each: f"{each.row.id} {each.word}, {each.seconds:.0f} s"
        )
    )
    write_file(options.out / PAGE, page(verdicts))
    write_picture(verdicts, options.out / "believed.png")
    print("".join(row_text(each, options.out) for each in verdicts if options.rows), end="")
    counted = [each for each in verdicts if each.word != "shown"]
    print(f"{sum(each.word == 'inside' for each in counted)} of {len(counted)} rows inside: {options.out / PAGE}")
    return int(bool(options.rows) and any(each.word == "outside" for each in counted))
