"""The command: `python -m clients.ppi ws://127.0.0.1:8000 --scans 1 --out ppi.png`.

Exit status: 0 done, 1 the feed could not be had or broke off, 2 wrong usage, 130 interrupted.
"""

import argparse
import asyncio
import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from radar_service.display.film import write_gif, write_mp4
from radar_service.display.picture import Drawing, Page, distance_label, render_image, render_png

from . import live
from .client import FeedClient, FeedError
from .film import film
from .options import FILMS, options
from .scans import ReceivedScan, ScanCollector, brightness, collect_scans
from .scope import Scope


def main(arguments: list[str] | None = None) -> int:
    """Receive, then draw and save, or show; returns the exit status."""
    asked = options(arguments)
    try:
        print(_shown(asked) if asked.live else _saved(asked))
    except (FeedError, OSError) as fault:
        print(f"clients.ppi: {fault}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("clients.ppi: interrupted; nothing was written", file=sys.stderr)
        return 130
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
        case _:
            ppi, heading = scans[-1].ppi, scans[-1].newest_heading
            picture = brightness(scans[-1], asked.dynamic_range_db)
            drawing = _drawing(scans[-1], asked) | Drawing(heading=heading, filled=ppi.filled)
            asked.out.write_bytes(render_png(picture, ppi.range_first, ppi.range_step, **drawing))
    if asked.npz:
        with asked.npz.open("wb") as file:
            np.savez_compressed(file, **arrays(scans))


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
    scan = collector.scans[-1]
    encoding = scan.hello["encoding"]["name"]
    lines = [
        f"{scan.hello['scene']['name']}, {scan.hello['radar']['name']}: {collector.done} scan(s) of {scan.azimuths} "
        f"azimuths to {distance_label(scan.ppi.range_end)}, {encoding}",
        f"last scan: {scan.azimuths - scan.missing} azimuths came, {scan.missing} missing, "
        f"heading {math.degrees(scan.newest_heading):05.1f}\N{DEGREE SIGN}",
        _account(client),
    ]
    if collector.restarts:
        lines.append(f"the radar changed scene or range {collector.restarts} time(s); the scans are of the last")
    return "\n".join([*lines, f"wrote {', '.join(map(str, files))}"])


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
