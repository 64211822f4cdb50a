"""The command: `python -m clients.ppi ws://127.0.0.1:8000 --scans 1 --out ppi.png`. It writes only the files that it is given.

Exit status: 0 done, 1 the feed could not be had or broke off, 2 wrong usage, 130 interrupted, 141 its reader has gone.
"""

import argparse
import asyncio
import math
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tqdm import tqdm

from clients.ppi import live
from clients.ppi.client import FeedClient, FeedError
from clients.ppi.film import film
from clients.ppi.options import FILMS, options
from clients.ppi.scans import ReceivedScan, ScanCollector, arrays, brightness, collect_scans
from clients.ppi.scope import Scope
from radar_service.display.film import write_gif, write_mp4
from radar_service.display.picture import Drawing, Page, distance_label, render_image, render_png
from radar_service.scan_file import write_arrays

READER_GONE = 141  # 128 + SIGPIPE, as shells report of programs that a closed pipe ends


def main(arguments: list[str] | None = None) -> int:
    """Receive, then draw and save, or show; returns the exit status."""
    asked = options(arguments)
    try:
        account = _shown(asked) if asked.live else _saved(asked)
    except (FeedError, OSError) as fault:
        print(f"clients.ppi: {fault}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("clients.ppi: interrupted; nothing was written", file=sys.stderr)
        return 130
    try:
        print(account, flush=True)
    except BrokenPipeError:  # the reader has gone; what was asked for is written
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the interpreter flushes once more at its end
        return READER_GONE
    return 0


def _client(asked: argparse.Namespace, **more: Any) -> FeedClient:
    return FeedClient(
        asked.url, encoding=asked.encoding, mode=asked.mode, timeout=asked.timeout, reconnect=asked.reconnect,
        token=asked.token_file or "", **more,
    )  # fmt: skip


def _shown(asked: argparse.Namespace) -> str:
    """Show the radar live; the account of it."""
    status = live.Status()
    client = _client(asked, bins=asked.bins or live.BINS, notice=status)
    asyncio.run(live.show(client, Scope(asked.dynamic_range_db, asked.range, asked.head_up), status))
    return _account(client)


def _saved(asked: argparse.Namespace) -> str:
    """Receive scans and write them; what was written."""
    client = _client(asked, bins=asked.bins, patience=asked.timeout, notice=_say)
    collector = asyncio.run(_receive(client, asked.scans, None if asked.npz or asked.kind in FILMS else 1))
    _save(list(collector.scans), asked)
    return _summary(client, collector, [path for path in (asked.out, asked.npz) if path])


def _say(text: str) -> None:
    tqdm.write(f"clients.ppi: {text}", file=sys.stderr)


async def _receive(client: FeedClient, scans: int, keep: int | None) -> ScanCollector:
    with tqdm(unit="spoke", disable=not sys.stderr.isatty(), leave=False) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.set_postfix(lost=client.ledger.lost, refresh=False)
            bar.update(min(done, total) - bar.n)

        async with client:
            return await collect_scans(client, scans, keep, show)


def _save(scans: list[ReceivedScan], asked: argparse.Namespace) -> None:
    match asked.kind:
        case ".gif":
            write_gif(asked.out, _frames(scans, asked), asked.fps)
        case ".mp4":
            write_mp4(asked.out, _frames(scans, asked), asked.fps)
        case ".png":
            ppi, heading = scans[-1].ppi, scans[-1].newest_heading
            picture = brightness(scans[-1], asked.dynamic_range_db)
            drawing = _drawing(scans[-1], asked) | Drawing(heading=heading, filled=ppi.filled)
            asked.out.write_bytes(render_png(picture, ppi.range_first, ppi.range_step, **drawing))
    if asked.npz:
        write_arrays(asked.npz, arrays(scans), compress=True)


def _drawing(scan: ReceivedScan, asked: argparse.Namespace) -> Drawing:
    title = f"{scan.hello['scene']['name']}\n{scan.hello['radar']['name']}"
    return Drawing(range_max=asked.range, size=asked.size, head_up=asked.head_up, title=title)


def _frames(scans: list[ReceivedScan], asked: argparse.Namespace) -> Iterator[Page]:
    """The pictures of a film, drawn one by one as they are taken."""
    ppi, drawing = scans[0].ppi, _drawing(scans[0], asked)
    frames = film(scans, asked.fps, asked.dynamic_range_db)
    for frame in tqdm(frames, unit="picture", disable=not sys.stderr.isatty(), leave=False):
        now = drawing | Drawing(heading=frame.heading, filled=frame.filled)
        yield render_image(frame.picture, ppi.range_first, ppi.range_step, **now)


def _summary(client: FeedClient, collector: ScanCollector, files: list[Path]) -> str:
    scan = collector.scans[-1]
    encoding = scan.hello["encoding"]["name"]
    lines = [
        f"{scan.hello['scene']['name']}, {scan.hello['radar']['name']}: {collector.done} scan(s) of {scan.azimuths} "
        f"azimuths to {distance_label(scan.ppi.range_end)}, {encoding}",
        f"last scan: {scan.azimuths - scan.missing} azimuths came, {scan.missing} missing, "
        f"heading {round(math.degrees(scan.newest_heading), 1) % 360.0:05.1f}\N{DEGREE SIGN}",
        _account(client),
    ]
    if collector.restarts:
        lines.append(f"the radar changed scene or range {collector.restarts} time(s); the scans are of the last")
    wrote = (
        f"wrote {', '.join(map(str, files))}" if files else "wrote nothing: --out FILE draws it, --npz FILE keeps its data"
    )
    return "\n".join([*lines, wrote])


def _account(client: FeedClient) -> str:
    """What came in all."""
    ledger, came_back = client.ledger, ""
    if client.reconnections:
        came_back = f"; tried to come back {client.reconnections} time(s)"
    return (
        f"in all: {ledger.received} spokes came, {ledger.announced} announced as lost, {ledger.holes} lost without a word"
        f"{came_back}"
    )


if __name__ == "__main__":
    sys.exit(main())
