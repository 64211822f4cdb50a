"""The command: `python -m clients.ppi ws://127.0.0.1:8000 --scans 1 --out ppi.png`.

Exit status: 0 done, 1 the feed could not be had or broke off, 2 wrong usage, 130 interrupted.
"""

import argparse
import asyncio
import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from clients.ppi.client import TIMEOUT, FeedClient, FeedError
from clients.ppi.scans import ReceivedScan, ScanCollector, brightness, collect_scans
from radar_service.display.picture import MAX_SIZE, MIN_SIZE, distance_label, render_png
from radar_service.stream import wire


def main(arguments: list[str] | None = None) -> int:
    """Receive, draw, save; returns the exit status."""
    options = parser().parse_args(arguments)
    client = FeedClient(
        options.url, encoding=options.encoding, bins=options.bins, mode=options.mode, timeout=options.timeout,
        reconnect=options.reconnect, token=options.token_file or "",
    )  # fmt: skip
    try:
        collector = asyncio.run(_receive(client, options.scans, None if options.npz else 1))
        _save(collector, options)
    except (FeedError, OSError) as fault:
        print(f"clients.ppi: {fault}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("clients.ppi: interrupted; nothing was written", file=sys.stderr)
        return 130
    print(_summary(client, collector, [p for p in (options.out, options.npz) if p]))
    return 0


def parser() -> argparse.ArgumentParser:
    """The command line."""
    p = argparse.ArgumentParser(prog="python -m clients.ppi", description="Receive whole scans of a radar and draw the PPI.")
    p.add_argument("url", help="feed, e.g. ws://127.0.0.1:8000/api/radars/0/feed; ws://HOST:PORT is radar 0")
    p.add_argument("--scans", type=_whole(1, 100_000), default=1, help="revolutions to receive; the last one is drawn")
    p.add_argument("--out", type=_writable, default=Path("ppi.png"), metavar="PNG", help="the picture (default ppi.png)")
    p.add_argument("--npz", type=_writable, metavar="FILE", help="all scans as arrays as well")
    p.add_argument("--size", type=_whole(MIN_SIZE, MAX_SIZE), default=900, metavar="PIXELS")
    p.add_argument("--range", type=_positive, metavar="M", help="radius of the picture (default: all that comes)")
    p.add_argument("--head-up", action="store_true", help="the bow at the top (default: north)")
    p.add_argument(
        "--encoding", choices=list(wire.DTYPES), default="u8", help="u8 is the display's video, the others are untouched"
    )
    p.add_argument("--bins", type=_whole(1, 65_536), help="range bins per spoke (default: every cell)")
    p.add_argument(
        "--dynamic-range-db", type=_positive, default=60.0, metavar="DB", help="of a picture that is not u8 (default 60)"
    )
    p.add_argument(
        "--mode", choices=["live", "lossless"], default="live", help="lossless: the simulation waits for this client"
    )
    p.add_argument(
        "--timeout", type=_positive, default=TIMEOUT, metavar="S", help=f"give up after this silence (default {TIMEOUT:g})"
    )
    p.add_argument("--token-file", type=_first_line, metavar="FILE", help="a file with the token that the service wants")
    p.add_argument("--reconnect", action="store_true", help="come back after a break and go on")
    return p


def _whole(low: int, high: int) -> Any:
    def number(text: str) -> int:
        if not (text.isdecimal() and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"{text}: a whole number from {low} to {high} is wanted")
        return int(text)

    return number


def _positive(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text}: a number above 0 is wanted")
    return number


def _first_line(text: str) -> str:
    try:
        return (Path(text).read_text().splitlines() or [""])[0].strip()
    except (OSError, ValueError) as fault:
        raise argparse.ArgumentTypeError(f"{text}: cannot be read ({fault})") from None


def _writable(text: str) -> Path:
    path = Path(text)
    if path.is_dir() or not path.absolute().parent.is_dir():  # said now, not after a minute of receiving
        raise argparse.ArgumentTypeError(
            f"{text}: not a file in a folder that exists; give another or make the folder first"
        )
    return path


async def _receive(client: FeedClient, scans: int, keep: int | None) -> ScanCollector:
    with tqdm(unit="spoke", disable=not sys.stderr.isatty(), leave=False) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.set_postfix(lost=client.ledger.lost, refresh=False)
            bar.update(min(done, total) - bar.n)

        async with client:
            return await collect_scans(client, scans, keep, show)


def _save(collector: ScanCollector, options: argparse.Namespace) -> None:
    scan, heading = collector.scans[-1], collector.scans[-1].newest_heading
    title = f"{scan.hello['scene']['name']}\n{scan.hello['radar']['name']}"
    ppi = scan.ppi
    png = render_png(
        brightness(scan, options.dynamic_range_db), ppi.range_first, ppi.range_step, range_max=options.range,
        size=options.size, heading=heading, head_up=options.head_up, title=title, filled=ppi.filled,
    )  # fmt: skip
    options.out.write_bytes(png)
    if options.npz:
        with options.npz.open("wb") as file:
            np.savez_compressed(file, **arrays(list(collector.scans)))


def arrays(scans: list[ReceivedScan]) -> dict[str, Any]:
    """Scans (S of them, all of one epoch) as named arrays.

    data (S, A, N) as sent; number (S, A), -1 where no spoke came; time [s], heading, course [rad], speed [m/s] (S, A) and
    position (S, A, 2) [m], NaN there; azimuth (A,) [rad], range (N,) [m]; the hello as JSON.
    """
    ppi = scans[0].ppi
    azimuths, bins = ppi.polar.shape
    each = {
        name: np.stack([getattr(scan, name) for scan in scans])
        for name in ("time", "heading", "course", "speed", "position", "blind")
    }
    return each | {
        "data": np.stack([scan.ppi.polar for scan in scans]),
        "number": np.stack([scan.ppi.number for scan in scans]),
        "azimuth": np.arange(azimuths) * (2.0 * np.pi / azimuths),
        "range": ppi.range_first + np.arange(bins) * ppi.range_step,
        "range_step": np.array(ppi.range_step),
        "hello": np.array(json.dumps(scans[0].hello, default=str)),
    }


def _summary(client: FeedClient, collector: ScanCollector, files: list[Path]) -> str:
    scan, ledger = collector.scans[-1], client.ledger
    encoding = scan.hello["encoding"]["name"]
    lines = [
        f"{scan.hello['scene']['name']}, {scan.hello['radar']['name']}: {collector.done} scan(s) of {scan.azimuths} "
        f"azimuths to {distance_label(scan.ppi.range_end)}, {encoding}",
        f"last scan: {scan.azimuths - scan.missing} azimuths came, {scan.missing} missing, "
        f"heading {math.degrees(scan.newest_heading):05.1f}\N{DEGREE SIGN}",
        f"in all: {ledger.received} spokes came, {ledger.announced} announced as lost, {ledger.holes} lost without a word",
    ]
    if collector.restarts:
        lines.append(f"the radar changed scene or range {collector.restarts} time(s); the scans are of the last")
    return "\n".join([*lines, f"wrote {', '.join(map(str, files))}"])


if __name__ == "__main__":
    sys.exit(main())
