"""The command line of `radar-ppi`."""

import argparse
import math
from functools import partial
from pathlib import Path

from radar_service import wire
from radar_service.display.film import MAX_FPS
from radar_service.display.palettes import DEFAULT_PALETTE, PALETTES
from radar_service.display.picture import MAX_SIZE, MIN_SIZE
from radar_service.display.units import add_unit
from radar_service.scans.file import SUFFIX
from radar_service.terminal import add_overwrite, add_whole_number, file_ending, number_between, prepare

from .client import TIMEOUT

PROGRAM = "radar-ppi"
PICTURE, FILM = ".png", ".gif"
PICTURE_SIZE, FILM_SIZE = 900, 480  # pixels; a revolution in the film size is about 3 MB of GIF
positive = partial(number_between, lower=0.0, upper=math.inf, allowed="a number above 0")


def options(arguments: list[str] | None) -> argparse.Namespace:
    """Returns the options with their defaults. Exits with status 2 if they contradict each other."""
    p = parser()
    chosen = p.parse_args(arguments)
    if chosen.live and (chosen.out or chosen.npz or chosen.scans):
        p.error("--live shows the radar until it is ended and writes nothing; leave out --out, --npz and --scans")
    if chosen.labels and not chosen.npz:
        p.error("--labels: goes into the file of --npz; add --npz FILE.npz, or leave --labels out")
    try:
        prepare((chosen.out, chosen.npz), chosen.overwrite)  # fails before anything is received
    except OSError as fault:
        p.error(f"{fault.filename}: {fault.strerror}")
    chosen.scans = chosen.scans or 1
    chosen.kind = chosen.out.suffix.lower() if chosen.out else ""
    chosen.size = chosen.size or (FILM_SIZE if chosen.kind == FILM else PICTURE_SIZE)
    return chosen


def parser() -> argparse.ArgumentParser:
    """The command line."""
    about = "Receive a radar: write a picture, a film or its data, or show it live."
    p = argparse.ArgumentParser(prog=PROGRAM, description=about)
    p.add_argument("url", help="feed, for example ws://127.0.0.1:8000/api/radars/0/feed; ws://HOST:PORT means radar 0")
    _add_output(p)
    _add_picture(p)
    _add_feed(p)
    return p


def _add_output(p: argparse.ArgumentParser) -> None:
    add_whole_number(p, "--scans", None, 1, 100_000, metavar="N", help="revolutions to receive (default 1)")
    shown = "x.png: a picture of the last of them; x.gif: a film of all of them"
    p.add_argument("--out", type=_picture, metavar="FILE", help=shown)
    arrays = partial(file_ending, suffix=SUFFIX)
    p.add_argument("--npz", type=arrays, metavar="FILE", help="x.npz: all of them as numpy arrays")
    add_overwrite(p)
    p.add_argument("--live", action="store_true", help="show the radar in this terminal; q ends it")


def _add_picture(p: argparse.ArgumentParser) -> None:
    width = f"width of the picture (default {PICTURE_SIZE}; of a film {FILM_SIZE})"
    add_whole_number(p, "--size", None, MIN_SIZE, MAX_SIZE, metavar="PIXELS", help=width)
    add_whole_number(p, "--fps", 10, 1, MAX_FPS, help="pictures per second of a film (default 10)")
    p.add_argument("--range", type=positive, metavar="M", help="radius of the picture (default: the whole range)")
    add_unit(p, "the picture")
    p.add_argument("--head-up", action="store_true", help="put the bow at the top (default: north)")
    p.add_argument(
        "--palette", choices=list(PALETTES), default=DEFAULT_PALETTE,
        help=f"colours of echoes, those of the page (default {DEFAULT_PALETTE})",
    )  # fmt: skip
    p.add_argument(
        "--dynamic-range-db",
        type=positive,
        default=60.0,
        metavar="DB",
        help="of a picture that is not u8 (default 60)",
    )


def _add_feed(p: argparse.ArgumentParser) -> None:
    p.add_argument(
        "--encoding",
        choices=list(wire.DTYPES),
        default="u8",
        help="u8 is the display's video; controls do not change the others",
    )
    add_whole_number(p, "--bins", None, 1, 65_536, help="range bins per spoke (default: every cell)")
    p.add_argument(
        "--labels", action="store_true", help="receive the number of the strongest source of each bin too, for --npz"
    )
    p.add_argument(
        "--mode", choices=["live", "lossless"], default="live", help="lossless: the simulation waits for this client"
    )
    p.add_argument(
        "--timeout",
        type=positive,
        default=TIMEOUT,
        metavar="S",
        help=f"end after this silence (default {TIMEOUT:g})",
    )
    p.add_argument(
        "--token-file", type=_first_line, metavar="FILE", help="file whose first line is the token of the service"
    )
    p.add_argument(
        "--reconnect",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="reconnect after a break and continue (default)",
    )


def _first_line(text: str) -> str:
    try:
        return (Path(text).read_text().splitlines() or [""])[0].strip()
    except (OSError, ValueError) as fault:
        raise argparse.ArgumentTypeError(f"{text}: cannot be read ({fault})") from None


def _picture(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in (PICTURE, FILM):
        allowed = "a picture is .png, a film .gif (arrays are written by --npz); give one of these endings"
        raise argparse.ArgumentTypeError(f"{text}: {allowed}")
    return path
