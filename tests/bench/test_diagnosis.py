"""Failed runs, the worst first; the report of a tracker that swaps two ships tells it on its first screen."""

import re
from pathlib import Path

import pytest

from radar_service.bench.bench import bench
from radar_service.bench.diagnosis import drawn_run, failed_runs, worst_first
from radar_service.bench.report import summary_table, write_report
from radar_service.bench.scenario import Limit, Scenario, load_scenario
from tests.bench.test_known_trackers import FAST_RADAR
from tests.bench.test_scenario import SMALL
from tests.clients.chromium import CHROMIUM, Browser

ROOT = Path(__file__).parents[2]
LIMITS = tuple(Limit(metric=metric, maximum=10, source="this test") for metric in ("one", "two"))
SHOWN = Limit(metric="shown", maximum=0, source="this test", decides=False)
SCENARIO = Scenario(**{**SMALL, "judges": "plots", "limit": (*LIMITS, SHOWN)})
SWAP = "scan 40: swap: eastbound and westbound swap tracks"


def run(seed: int, one: float, two: float, fails: bool = False) -> dict:
    metrics = {} if fails else {"one": one, "two": two, "shown": 99.0, "ospa_m": one}
    return {"seed": seed, "failure": {} if fails else None, "metrics": metrics, "events": [], "scans": []}


def test_failures_come_first_then_the_most_limits_then_gross_misses_then_ospa() -> None:
    runs = [
        run(0, 1, 1),
        run(1, 11, 0),
        run(2, 12, 0),
        run(3, 21, 0),
        run(4, 11, 11),
        run(5, 0, 0, fails=True),
        run(6, 2, 2),
    ]
    runs[5]["failure"] = {"scan": 3}
    assert [each["seed"] for each in worst_first(SCENARIO, runs)] == [5, 4, 3, 2, 1, 6, 0]
    assert [each["seed"] for each in failed_runs(SCENARIO, runs)] == [5, 4, 3, 2, 1]
    assert failed_runs(SCENARIO, runs)[1]["missed"] == {"one": 11, "two": 11}


def test_a_run_without_a_scan_is_not_drawn() -> None:
    assert drawn_run(SCENARIO, [run(0, 1, 1)]) is None


@pytest.fixture(scope="module")
def swapped(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, Path]:
    """The report of a tracker that swaps two ships in two seeds, and its folder."""
    folder = tmp_path_factory.mktemp("swaps")
    scenario = load_scenario("crossing-cpa-500")
    scene = {**scenario.scene, "radar": {**scenario.scene["radar"], **FAST_RADAR}}
    fast = scenario.model_copy(update={"scene": scene, "scans": 45})
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(ROOT))
        report, runs = bench([fast], 2, "tests.bench.known_trackers:Swaps", folder / "out", smoke=True)
    write_report(report, {fast.name: drawn_run(fast, runs[fast.name])}, folder / "out")
    return report, folder / "out" / "report.html"


def test_the_summary_of_a_swap_names_scan_and_ships(swapped: tuple[dict, Path]) -> None:
    report, _ = swapped
    assert "identity_changes" in report["scenarios"][0]["failed_runs"][0]["missed"]
    first, scenario, event = summary_table(report).splitlines()[:3]
    assert (
        first.split()[0] == "scenario" and scenario.split()[:4] == ["crossing-cpa-500", "fail", "2", "of"] and SWAP in event
    )


def test_the_page_tells_it_before_the_picture_and_draws_the_worst_seed(swapped: tuple[dict, Path]) -> None:
    page = swapped[1].read_text()
    worst = swapped[0]["scenarios"][0]["failed_runs"][0]["seed"]
    assert page.index("<table>") < page.index(SWAP) < page.index("<img") < page.index("95 % value")
    assert re.search(rf'<img alt="seed {worst}: ', page)


@pytest.mark.browser
@pytest.mark.skipif(not CHROMIUM.exists(), reason=f"{CHROMIUM} is absent: install the Debian package chromium")
def test_scan_ships_and_picture_are_within_one_screen(swapped: tuple[dict, Path], tmp_path: Path) -> None:
    """Of 1280 x 800 pixels, that of a small laptop."""
    browser = Browser(tmp_path)
    try:
        page = browser.open(swapped[1].as_uri(), 1280, 800)
        page.wait("document.querySelector('img').naturalHeight > 0 && document.readyState === 'complete'")
        bottom, width = page.ask(
            "(({bottom, width}) => [bottom, width])(document.querySelector('img').getBoundingClientRect())"
        )
        assert bottom <= 800 and width > 1000
        assert page.ask(f"[...document.querySelectorAll('td')].find(x => x.innerText.includes('{SWAP}')).offsetTop") < 400
    finally:
        browser.close()
