"""The command: `radar-ppi ws://127.0.0.1:8000 --scans 1 --out ppi.png`; in a checkout also `python -m clients.ppi`.

Exit status: 0 done, 1 the feed failed or a file cannot be written, 2 wrong usage, 130 interrupted.
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
from .client import FeedClient
from .errors import FeedError
from .film import film
from .options import FILMS, PROGRAM, options
from .scans import ReceivedScan, ScanCollector, brightness, collect_scans
from .scope import Scope


def main(arguments: list[str] | None = None) -> int:
    """Receives scans and writes them, or shows the radar live; returns the exit status."""
    chosen = options(arguments)
    try:
        print(_show_live(chosen) if chosen.live else _receive_and_save(chosen))
    except (FeedError, OSError) as fault:
        print(f"{PROGRAM}: {fault}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"{PROGRAM}: interrupted; nothing was written", file=sys.stderr)
        return 130
    return 0


def _client(chosen: argparse.Namespace, **more: Any) -> FeedClient:
    return FeedClient(
        chosen.url, encoding=chosen.encoding, mode=chosen.mode, timeout=chosen.timeout, reconnect=chosen.reconnect,
        token=chosen.token_file or "", **more,
    )  # fmt: skip


def _show_live(chosen: argparse.Namespace) -> str:
    """Shows the radar until the user ends it; returns the counts of spokes as a sentence."""
    status = live.Status()
    client = _client(chosen, bins=chosen.bins or live.BINS, notice=status)
    asyncio.run(live.show(client, Scope(chosen.dynamic_range_db, chosen.range, chosen.head_up), status))
    return _counts(client)


def _receive_and_save(chosen: argparse.Namespace) -> str:
    """Receives scans and writes them; returns a summary."""
    client = _client(chosen, bins=chosen.bins, patience=chosen.timeout, notice=_print_notice)
    collector = asyncio.run(_receive(client, chosen.scans, None if chosen.npz or chosen.kind in FILMS else 1))
    _save(list(collector.scans), chosen)
    return _summary(client, collector, [path for path in (chosen.out, chosen.npz) if path])


def _print_notice(text: str) -> None:
    tqdm.write(f"{PROGRAM}: {text}", file=sys.stderr)


async def _receive(client: FeedClient, scans: int, keep: int | None) -> ScanCollector:
    with tqdm(unit="spoke", disable=not sys.stderr.isatty(), leave=False) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.set_postfix(lost=client.sequence.lost, refresh=False)
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


def _drawing(scan: ReceivedScan, chosen: argparse.Namespace) -> Drawing:
    title = f"{scan.hello['scene']['name']}\n{scan.hello['radar']['name']}"
    return Drawing(range_max=chosen.range, size=chosen.size, head_up=chosen.head_up, title=title)


def _frames(scans: list[ReceivedScan], chosen: argparse.Namespace) -> Iterator[Page]:
    """Draws the pictures of a film one by one."""
    ppi, drawing = scans[0].ppi, _drawing(scans[0], chosen)
    frames = film(scans, chosen.fps, chosen.dynamic_range_db)
    for frame in tqdm(frames, unit="picture", disable=not sys.stderr.isatty(), leave=False):
        details = drawing | Drawing(heading=frame.heading, filled=frame.filled)
        yield render_image(frame.picture, ppi.range_first, ppi.range_step, **details)


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
        f"last scan: {scan.azimuths - scan.missing} azimuths received, {scan.missing} missing, "
        f"heading {round(math.degrees(scan.newest_heading), 1) % 360.0:05.1f}\N{DEGREE SIGN}",
        _counts(client),
    ]
    if collector.restarts:
        lines.append(f"the radar changed scene or range {collector.restarts} time(s); these scans are newer")
    return "\n".join([*lines, f"wrote {', '.join(map(str, files))}"])


def _counts(client: FeedClient) -> str:
    """Counts of received and lost spokes, and of attempts to reconnect."""
    sequence = client.sequence
    attempts = f"; tried to reconnect {client.reconnections} time(s)" if client.reconnections else ""
    return (
        f"in all: {sequence.received} spokes received, {sequence.announced} lost and announced, "
        f"{sequence.missing} lost and not announced{attempts}"
    )


if __name__ == "__main__":
    sys.exit(main())
