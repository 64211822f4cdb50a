"""The product's own extractor as a program under test: `python -m radar_service.bench.video_child gnn`.

It reads the video of a run, and gives the plots to a tracker by name; without one it answers the plots.
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, replace
from typing import Any, TextIO

from radar_service.bench.run import extractor_of
from radar_service.bench.scenario import PlotSettings
from radar_service.bench.trackers.callable_child import scan_of
from radar_service.bench.trackers.tracker import TrackerInput
from radar_service.bench.trackers.trackers import tracker_for
from radar_service.radar_feed import RemoteFeed
from radar_service.scene_file import load_scene

Line = Mapping[str, Any]


def plots_of(video: Line, lines: Iterable[str]) -> Iterator[TrackerInput]:
    """Yields each line with the plots of its scan. video: of a header. Raises RuntimeError where the feed ends."""
    scene = load_scene({"name": "video", "radar": video["radar"]})
    extractor = extractor_of(PlotSettings(**video["plots"]), scene)
    feed = RemoteFeed(video["address"], video["id"], truth=False)
    for line, scan in zip(lines, feed.scans(sys.maxsize), strict=False):  # a line first: the bench may end the run
        yield replace(scan_of(json.loads(line)), plots=extractor.add(scan).plots)
    feed.close()


def serve(tracker: str | None, lines: Iterator[str], answers: TextIO) -> None:
    """Answers each scan of some lines, of which the first one is the header. Raises as its parts do."""
    header = json.loads(next(lines))
    behind = tracker_for(tracker, header) if tracker else None
    for given in plots_of(header["video"], lines):
        key, records = ("tracks", behind.update(given)) if behind else ("plots", given.plots)
        answer = {"type": key, "scan": given.scan, key: [asdict(record) for record in records]}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    serve(sys.argv[1] if len(sys.argv) > 1 else None, iter(sys.stdin), sys.stdout)
