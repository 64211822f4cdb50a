"""Video for a program under test: the plots are those of the simulator, truth is closed, and a service that fails is told."""

import io
import json
from contextlib import contextmanager
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from websockets.exceptions import ConnectionClosedError

from radar_service.bench import single_run as single_module
from radar_service.bench.run import observed
from radar_service.bench.scenario import PLOT_METRICS, ScenarioError, load_scenario, with_video
from radar_service.bench.single_run import single_run
from radar_service.bench.trackers.tracker import AisTarget
from radar_service.bench.video import Video, program_on_video, video_of
from radar_service.bench.video_child import plots_of
from tests.bench.test_bench import small
from tests.bench.trackers.test_process_tracker import program

PLOT_AFTER_PLOT = """
import json, sys
header = json.loads(sys.stdin.readline())
assert header["video"]["feed"]
for line in sys.stdin:
    scan = json.loads(line)
    assert scan["plots"] == []
    if scan["scan"] == 1:
        WRONG
    print(json.dumps({"type": "tracks", "scan": scan["scan"], "tracks": []}), flush=True)
"""


def refused(url: str, method: str = "GET") -> tuple[int, list[str]]:
    with pytest.raises(HTTPError) as error:
        urlopen(Request(url, b"{}" if method != "GET" else None, {"Content-Type": "application/json"}, method=method))
    return error.value.code, json.load(error.value)["detail"]


def test_a_program_reads_the_video_of_the_plots_and_no_truth(tmp_path: Path) -> None:
    """Plots of the extractor behind the feed are those of the bench; and a service that dies says so."""
    scenario = with_video(small(tmp_path, 3))
    hull = {**scenario.scene["body"][0], "shape": "hull", "length_m": 90, "beam_m": 15, "height_m": 15, "rcs_dbsm": 20}
    scenario = scenario.model_copy(update={"scene": {**scenario.scene, "body": [{**hull, "position_m": [500, 300, 0]}]}})
    with video_of(scenario, 5, tmp_path / "plots") as video:
        assert [*(tmp_path / "plots").iterdir()] == []  # the scene has gone before the program starts
        root = f"http://{video.header['address']}/api/radars/0"
        assert refused(f"{root}/truth") == (403, ["truth: this server does not give it; start it with --truth"])
        assert refused(f"{root}/controls", "PATCH")[0] == refused(f"{root}/scene", "PUT")[0] == 401
        told = json.load(urlopen(root))
        assert (told["seed"], told["scene"]["bodies"], told["scene"]["name"]) == (0, 0, "")
        ais = AisTarget(time=1.0, mmsi=211000001, east=9.0, north=2007.0, speed=5.0, course=1.5, station_class="A")
        scans = [replace(each.given, ais=(ais,)) for each in observed(scenario, 5)]
        given = list(plots_of(video.header, [json.dumps(replace(scan, plots=()).as_dict()) for scan in scans]))
        assert given == scans and sum(len(each.plots) for each in given) and video.fault() is None
        video.service.process.kill()
        video.service.process.wait()
        assert video.fault() == "the service has ended: exit status -9"


def test_a_service_that_takes_no_more_connections_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(HTTPConnection, "request", lambda *_: None)
    monkeypatch.setattr(HTTPConnection, "getresponse", lambda _: io.BytesIO(b"this address has all the connections"))
    fault = Video({}, SimpleNamespace(end=None, address="x")).fault()  # type: ignore[arg-type]
    assert fault and fault.startswith("the service does not answer: ")


@pytest.mark.parametrize("error", [TimeoutError("late"), ConnectionClosedError(None, None)])
def test_a_radar_that_cannot_be_reached_is_told(error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    @contextmanager
    def running(*_: object) -> Any:
        yield SimpleNamespace(address="x")

    def connect(*_: object, **options: object) -> None:
        raise error

    scenario, other = with_video(small(tmp_path, 3)), {"id": "other"}
    both = [{"id": "first", **scenario.scene["radar"]}, {**scenario.scene["radar"], **other}]
    scenario = scenario.model_copy(update={"scene": {**scenario.scene, "radar": both}, "radar": "first"})
    monkeypatch.setattr("radar_service.bench.video.service", running)
    monkeypatch.setattr("radar_service.radar_feed.connect", connect)
    run = single_run(scenario, 0, "none", tmp_path / "plots")
    assert run["failure"]["message"] == f"video: small: radar other cannot be reached: {error}"


def without_service(monkeypatch: pytest.MonkeyPatch, told: str | None = None) -> None:
    """Lets runs have a video whose service is none. told: what goes wrong with it."""

    class Faulty(Video):
        def fault(self) -> str | None:
            return told

    @contextmanager
    def video(*_: object) -> Any:
        yield Faulty({"feed": "ws://nowhere"}, None)  # type: ignore[arg-type]

    monkeypatch.setattr(single_module, "video_of", video)


@pytest.mark.parametrize(
    ("wrong", "fault", "message"),
    [
        ("break", None, "has ended before it answered scan 1"),
        ("break", "the service has ended: exit status -9", "video: the service has ended: exit status -9; then tracker: "),
        ("pass", "its radar was started again 1 times", "video: its radar was started again 1 times"),
    ],
)
def test_a_program_or_a_service_that_fails_is_a_failed_run(
    wrong: str, fault: str | None, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_service(monkeypatch, fault)
    command = program(tmp_path, PLOT_AFTER_PLOT.replace("WRONG", wrong))
    run = single_run(with_video(small(tmp_path, 3)), 0, command, tmp_path / "plots")
    assert message in run["failure"]["message"] and run["failure"]["scan"] == (1 if wrong == "break" else 3)


def test_a_tracker_that_takes_plots_runs_behind_the_extractor() -> None:
    assert program_on_video("./mine --fast") == "./mine --fast" and program_on_video("ws://host:1") == "ws://host:1"
    assert program_on_video("gnn").endswith(" -m radar_service.bench.video_child gnn")
    assert program_on_video("opencpn {feed}", "ttm").endswith(" -m radar_service.bench.ttm_child opencpn {feed}")
    assert program_on_video("mine:Tracker").endswith(".video_child mine:Tracker")


EXTRACTOR = """
import json, sys
header = json.loads(sys.stdin.readline())
assert header["video"]["feed"]
for line in sys.stdin:
    scan = json.loads(line)["scan"]
    time, east, north = 2.5 * scan + 0.412, 500.0, 300.0
    for _ in range(9):
        east = 500.0 + 20 * 1852 / 3600 * time
        time = 2.5 * scan + math.atan2(east, north) / (2 * math.pi) * 2.5
    plots = [{"time": time + LATE, "range": math.hypot(east, north), "bearing": math.atan2(east, north)}] * (scan % 2 + 1)
    print(json.dumps({"type": "plots", "scan": scan, "plots": plots}), flush=True)
"""


def test_an_extractor_is_judged_by_its_plots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of scans 1 to 3 two have a plot too many; a plot of the future is told."""
    without_service(monkeypatch)
    scenario = with_video(small(tmp_path, 4), "plots")
    code = EXTRACTOR.replace("import json", "import math, json")
    run = single_run(scenario, 0, program(tmp_path, code.replace("LATE", "0")), tmp_path / "plots")
    metrics = run["metrics"]
    assert (metrics["detected"], metrics["false_plots"]) == (1.0, pytest.approx(2.0 / 3.0))
    assert abs(metrics["range_bias_m"]) < 12.0 and metrics.keys() == set(PLOT_METRICS) and scenario.limits == ()
    failed = single_run(scenario, 0, program(tmp_path, code.replace("LATE", "3")), tmp_path / "plots")["failure"]
    assert failed["scan"] == 0 and "has a plot at 3.4" in failed["message"]


def test_a_recording_has_no_video() -> None:
    with pytest.raises(ScenarioError, match="real/autoferry-2: its plots are recorded; leave --input video out"):
        with_video(load_scenario("real/autoferry-2"))
