"""Video for a program under test: the native feed of a blind service, which each run has of its own.

The service plays as fast as the program reads. It tells neither truth, scene nor seed, and takes no commands.
"""

import json
import shlex
import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from radar_service.bench.kept_plots import named_files
from radar_service.bench.run import pfa_of, threshold_kind
from radar_service.bench.scenario import Scenario
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.trackers import is_program
from radar_service.radar_feed import RunningService, release, service
from radar_service.scene_file import load_scene, model_from, radar_entries
from radar_service.terminal import make_folder
from radar_service.world import known_radar

CHILD = "radar_service.bench.video_child"  # the program that gives plots of the product's own extractor to a tracker
TTM_CHILD = "radar_service.bench.ttm_child"
HEALTH_SECONDS = 20.0


class VideoError(TrackerError):
    """The service of the video, not the program, has failed."""


@dataclass(frozen=True)
class Video:
    """The video of one run. header: what a program is told of it."""

    header: Mapping[str, Any]
    service: RunningService

    def fault(self) -> str | None:
        """Returns what went wrong with the service; None where nothing did."""
        if (end := self.service.end) is not None:
            return f"the service has ended: {end}"
        try:
            with closing(HTTPConnection(self.service.address, timeout=HEALTH_SECONDS)) as connection:
                connection.request("GET", "/api/health")
                health = json.load(connection.getresponse())  # of a radar that has failed, too
        except (OSError, HTTPException, ValueError) as error:
            return f"the service does not answer: {error}"
        faults = [radar["fault"] for radar in health["radars"] if radar["fault"]]
        restarts = sum(radar["restarts"] for radar in health["radars"])
        return faults[0] if faults else f"its radar was started again {restarts} times" if restarts else None


@contextmanager
def video_of(scenario: Scenario, seed: int, plots: Path) -> Iterator[Video]:
    """Runs the service of a scenario and a seed. plots: the folder that keeps truth, and the scene until the service has it.

    Raises VideoError where the service does not start, SceneError and OSError.
    """
    scene = scenario.scene_for(seed)
    ids = [entry.id for entry in radar_entries(model_from(scene).radar)]
    radar = known_radar(scenario.radar, ids)
    make_folder(plots)
    with ExitStack() as ending:
        root = Path(ending.enter_context(folder := TemporaryDirectory(dir=plots)))
        for name, path in named_files(scene, scenario.folder).items():
            make_folder((root / name).parent)
            shutil.copy(path, root / name)
        (file := root / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
        pace = 1.0 if scenario.answers == "ttm" else "max"
        try:
            started = ending.enter_context(service(file, seed, pace, scenario.fidelity, ["--blind", *scenario.serve]))
            release(started.address, [other for other in ids if other != radar])
        except RuntimeError as error:
            raise VideoError(f"video: {scenario.name}: {error}") from None
        folder.cleanup()
        yield Video(_header(scenario, started.address, radar), started)


def _header(scenario: Scenario, address: str, radar: str) -> dict[str, Any]:
    """What a program is told: where the video is, and by which keys of a scene file and settings of plots it may be read."""
    tables = scenario.scene.get("radar", {})
    own = tables if isinstance(tables, Mapping) else next(table for table in tables if table["id"] == radar)
    scene = load_scene(scenario.scene, folder=scenario.folder).for_radar(scenario.radar)
    kind = threshold_kind(scenario.plots, scene)
    settings = scenario.plots.model_copy(update={"threshold": kind, "pfa": pfa_of(scenario.plots, kind)})
    return {
        "feed": f"ws://{address}/api/radars/{radar}/feed", "address": address, "id": radar,
        "radar": {key: value for key, value in own.items() if key not in ("id", "name", "platform")},
        "origin": scene.origin, "answers": scenario.answers, "plots": settings.model_dump(),
    }  # fmt: skip


def program_on_video(tracker: str = "", answers: str = "tracks") -> str:
    """Returns the program or server behind a tracker's name: one that takes plots runs behind the product's own extractor, which
    answers plots without one; one that answers TTM behind what reads these."""
    if answers == "ttm":
        return f"{shlex.quote(sys.executable)} -m {TTM_CHILD} {tracker}"
    return tracker if tracker and is_program(tracker) else shlex.join([sys.executable, "-m", CHILD, *tracker.split()])
