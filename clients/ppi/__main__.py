"""The command: `radar-ppi ws://127.0.0.1:8000 --scans 1 --out ppi.png`; in a checkout also `python -m clients.ppi`.

It writes only the files that it is given. Exit status: 0 done, 1 the feed failed or a file cannot be written, 2 wrong usage,
130 interrupted, 141 the reader of its output has gone.
"""

import argparse
import asyncio
import math
import os
import signal
import sys
from collections import deque
from collections.abc import Iterator
from typing import Any

from tqdm import tqdm

from radar_service.display.film import write_gif
from radar_service.display.picture import Drawing, Page, render_image, render_png
from radar_service.display.units import range_text
from radar_service.scans.file import write_arrays
from radar_service.terminal import write_file

from . import live
from .client import FeedClient
from .errors import FeedError
from .film import film
from .options import FILM, PROGRAM, options
from .scans import ReceivedScan, ScanCollector, arrays, brightness, collect_scans
from .terminal_ppi import TerminalPpi

PIPE_CLOSED = 141  # 128 + SIGPIPE, as shells report programs that a closed pipe ends


def main(arguments: list[str] | None = None) -> int:
    """Receives scans and writes them, or shows the radar live; returns the exit status."""
    chosen = options(arguments)
    try:
        summary = _show_live(chosen) if chosen.live else _receive_and_save(chosen)
    except (FeedError, OSError) as fault:
        print(f"{PROGRAM}: {fault}", file=sys.stderr)
        return 1
    except (KeyboardInterrupt, asyncio.CancelledError):
        print(f"{PROGRAM}: interrupted; nothing was written", file=sys.stderr)
        return 130
    try:
        print(summary, flush=True)
    except OSError as fault:  # the reader has gone, or the disk is full; all files are written
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the interpreter flushes once more at its end
        if isinstance(fault, BrokenPipeError):
            return PIPE_CLOSED
        print(f"{PROGRAM}: standard output: {fault.strerror}", file=sys.stderr)
        return 1
    return 0


def _client(chosen: argparse.Namespace, **more: Any) -> FeedClient:
    return FeedClient(
        chosen.url, encoding=chosen.encoding, mode=chosen.mode, timeout=chosen.timeout, reconnect=chosen.reconnect,
        token=chosen.token_file or "", **more,
    )  # fmt: skip


def _show_live(chosen: argparse.Namespace) -> str:
    """Shows the radar until the user ends it; returns the counts of spokes as a sentence."""
    notices = deque(["no break so far"], maxlen=1)
    client = _client(chosen, bins=chosen.bins or live.BINS, notice=notices.append)
    ppi = TerminalPpi(chosen.dynamic_range_db, chosen.range, chosen.head_up, chosen.palette, chosen.unit)
    asyncio.run(live.show(client, ppi, notices))
    return _counts(client)


def _receive_and_save(chosen: argparse.Namespace) -> str:
    """Receives scans and writes them; returns a summary."""
    client = _client(chosen, bins=chosen.bins, patience=chosen.timeout, notice=_print_notice, labels=chosen.labels)
    collector = asyncio.run(_receive(client, chosen.scans, None if chosen.npz or chosen.kind == FILM else 1))
    _save(list(collector.scans), chosen)
    return _summary(client, collector, chosen)


def _print_notice(text: str) -> None:
    tqdm.write(f"{PROGRAM}: {text}", file=sys.stderr)


async def _receive(client: FeedClient, scans: int, keep: int | None) -> ScanCollector:
    if sys.platform != "win32" and (task := asyncio.current_task()):
        # The loop's own handler of Ctrl-C would cancel in the middle of a callback, which then fails with a traceback.
        asyncio.get_running_loop().add_signal_handler(signal.SIGINT, task.cancel)
    with tqdm(unit="spoke", disable=not sys.stderr.isatty(), leave=False) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.set_postfix(lost=client.sequence.lost, refresh=False)
            bar.update(min(done, total) - bar.n)

        async with client:
            return await collect_scans(client, scans, keep, show)


def _save(scans: list[ReceivedScan], chosen: argparse.Namespace) -> None:
    match chosen.kind:
        case ".gif":
            write_gif(chosen.out, _frames(scans, chosen), chosen.fps, chosen.palette)
        case ".png":
            ppi, heading = scans[-1].ppi, scans[-1].newest_heading
            picture = brightness(scans[-1], chosen.dynamic_range_db)
            drawing = _drawing(scans[-1], chosen) | Drawing(heading=heading, filled=ppi.filled)
            write_file(chosen.out, render_png(picture, ppi.range_first, ppi.range_step, **drawing))
    if chosen.npz:
        write_arrays(chosen.npz, arrays(scans), compress=True)


def _drawing(scan: ReceivedScan, chosen: argparse.Namespace) -> Drawing:
    title = f"{scan.hello['scene']['name']}\n{scan.hello['radar']['name']}"
    return Drawing(
        range_max=chosen.range, size=chosen.size, head_up=chosen.head_up, title=title, palette=chosen.palette,
        unit=chosen.unit,
    )  # fmt: skip


def _frames(scans: list[ReceivedScan], chosen: argparse.Namespace) -> Iterator[Page]:
    """Draws the pictures of a film one by one."""
    ppi, drawing = scans[0].ppi, _drawing(scans[0], chosen)
    frames = film(scans, chosen.fps, chosen.dynamic_range_db)
    for frame in tqdm(frames, unit="picture", disable=not sys.stderr.isatty(), leave=False):
        details = drawing | Drawing(heading=frame.heading, filled=frame.filled)
        yield render_image(frame.picture, ppi.range_first, ppi.range_step, **details)


def _summary(client: FeedClient, collector: ScanCollector, chosen: argparse.Namespace) -> str:
    files = [path for path in (chosen.out, chosen.npz) if path]
    scan = collector.scans[-1]
    encoding = scan.hello["encoding"]["name"]
    lines = [
        f"{scan.hello['scene']['name']}, {scan.hello['radar']['name']}: {collector.done} scan(s) of {scan.azimuths} "
        f"azimuths to {range_text(scan.ppi.range_end, chosen.unit)}, {encoding}",
        f"last scan: {scan.azimuths - scan.missing} azimuths received, {scan.missing} missing, "
        f"heading {heading_text(scan.newest_heading)}",
        _counts(client),
    ]
    if collector.restarts:
        lines.append(f"the radar changed scene or range {collector.restarts} time(s); these scans are newer")
    wrote = (
        f"wrote {', '.join(map(str, files))}" if files else "wrote no file: --out FILE draws it, --npz FILE saves its data"
    )
    return "\n".join([*lines, wrote])


def heading_text(heading: float) -> str:
    """Returns a heading [rad] in degrees; "lost" for NaN."""
    return "lost" if math.isnan(heading) else f"{round(math.degrees(heading), 1) % 360.0:05.1f}\N{DEGREE SIGN}"


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
