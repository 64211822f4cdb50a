"""The page against the real service: the picture of a scene, a thin line, the token, and a service that is killed."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.request import Request, urlopen

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

import scenes
from tests.clients.chromium import Browser, Page
from tests.clients.conftest import QUICK
from tests.clients.screen import BARE, BROWSER, PIXELS, box, seen
from tests.clients.test_web_thin_line import CLOCK, ask_time

pytestmark = BROWSER

HEADING_DEG = 70.0
COMMAND, READ = "command-" * 3, "reading-" * 3
CONNECTED = "document.getElementById('connection').textContent === 'Connected'"
DRAWN = "Number(document.getElementById('scope').dataset.drawn?.split(':')[1]) > 0"
EPOCH = "document.getElementById('scope').dataset.drawn?.split(':')[0]"
ENTER = "document.getElementById('token').value = '{}'; document.getElementById('access').requestSubmit(); 1"
ASKING = "!document.getElementById('access').hidden"

Serve = Callable[..., tuple[str, "subprocess.Popen[str]"]]


def end(service: "subprocess.Popen[str]") -> None:
    """Kill -9; more than once does no harm."""
    service.kill()
    service.wait()
    assert service.stdout is not None
    service.stdout.close()


def ask(address: str, method: str, body: object = None) -> None:
    """Sends a request that the service must grant, with the token."""
    headers = {"content-type": "application/json", "authorization": f"Bearer {COMMAND}"}
    with urlopen(Request(address, json.dumps(body).encode(), headers, method=method)) as answer:
        assert answer.status == 200


@pytest.fixture(scope="module")
def serve() -> Iterator[Serve]:
    services: list[subprocess.Popen[str]] = []

    def start(*options: str) -> tuple[str, "subprocess.Popen[str]"]:
        command = [sys.executable, "-m", "radar_service", "serve", "--pace", "4", *options]
        services.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
        assert services[-1].stdout is not None
        return services[-1].stdout.readline().split("open ")[1].strip(), services[-1]

    yield start
    for service in services:
        end(service)


def test_the_page_requests_the_token_and_reconnects_with_it_to_a_radar_that_errs(
    browser: Browser, serve: Serve, tmp_path: Path
) -> None:
    for name, token in (("token", COMMAND), ("reading", READ)):
        (tmp_path / name).write_text(token)
    files = "--token-file", str(tmp_path / "token"), "--token-file-for-reading", str(tmp_path / "reading")
    address, service = serve("orientation", "--port", "0", *files)
    page = browser.open(f"{address}?{BARE}", first=QUICK)
    page.wait(ASKING)
    page.ask(ENTER.format("wrong-token-wrong-token"))
    page.wait(ASKING)
    page.ask(ENTER.format(READ))
    page.wait(f"{CONNECTED} && {DRAWN}")
    page.ask("document.getElementById('transmit').click(); 1")  # which the token for reading does not allow
    page.wait("document.getElementById('alerts').textContent.includes('needed to command')")
    page.wait(ASKING)
    page.ask(ENTER.format(COMMAND))
    page.wait(f"{CONNECTED} && !({ASKING})")
    page.ask("document.getElementById('transmit').click(); 1")
    page.wait("document.getElementById('transmit').ariaPressed === 'false'")
    assert COMMAND not in page.ask("location.href") and READ not in page.ask("location.href")
    page.ask("document.getElementById('transmit').click(); 1")
    page.wait("document.getElementById('transmit').ariaPressed === 'true'")
    first = page.ask(EPOCH)
    end(service)
    page.wait("!document.getElementById('banner').hidden")  # it says so on the screen
    port = address.rstrip("/").rpartition(":")[2]
    _, again = serve("orientation", "--port", port, *files)
    page.wait(f"{CONNECTED} && {DRAWN} && {EPOCH} !== '{first}'")
    broken = len(page.faults())  # the browser tells of each connection that is refused
    errors = {"feed": {"drop_rate": 0.1, "repeat_rate": 0.1, "late_rate": 0.1, "swap_rate": 0.1, "heading_lost_s": [[0, 1e9]]},
              "profile": "imo-a823"}  # fmt: skip
    ask(f"{address}api/radars/0/errors", "PATCH", errors)
    page.wait("document.getElementById('heading-text').textContent === 'Lost'")
    before = page.ask("Number(document.getElementById('scope').dataset.drawn.split(':')[1])")
    page.wait(f"Number(document.getElementById('scope').dataset.drawn.split(':')[1]) > {before} + 400")
    assert len(page.faults()) == broken
    ask(f"{address}api/radars/0/errors", "DELETE")
    page.wait("document.getElementById('heading-text').textContent !== 'Lost'")
    page.ask("sessionStorage.clear(); 1")
    page.close()
    end(again)


@pytest.fixture(scope="module")
def orientation(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of a service with the scene `orientation`, own ship turned to HEADING_DEG."""
    text = (Path(scenes.__file__).parent / "orientation.toml").read_text()
    assert text.count("heading_deg = 0\n") == 1
    scene = tmp_path_factory.mktemp("scene") / "orientation.toml"
    scene.write_text(text.replace("heading_deg = 0\n", f"heading_deg = {HEADING_DEG}\n"))
    return serve(str(scene), "--port", "0")[0]


def strong_spots(page: Page) -> NDArray[np.float64]:
    """Centroids (n, 2) of the strong echoes, pixels right of and below own ship, the nearest first."""
    page.ask("void (document.getElementById('banner').style.visibility = 'hidden')")  # a busy machine is told of as too slow
    screen, (left, top, side) = seen(page), box(page)
    yellow = screen[..., 0] - screen[..., 2]  # the overlay has none
    labels, count = ndimage.label(yellow > 0.6 * yellow.max())  # the scene's three are equally strong, sidelobes faint
    positions = np.array(ndimage.center_of_mass(labels > 0, labels, range(1, count + 1)))[:, ::-1] + 0.5
    spots: NDArray[np.float64] = positions - (left + side / 2, top + side / 2)
    return spots[np.argsort(np.hypot(*spots.T))]


NEXT = "Number(document.getElementById('scope').dataset.drawn.split(':')[1])"
# A whole scan and a batch were drawn without a loss: a busy machine loses spokes, and counts anew from there.
WHOLE_SCAN = f"""(() => {{
    const lost = document.getElementById('lost-text').textContent;
    if (lost !== window.lostBefore) [window.lostBefore, window.start] = [lost, {NEXT}];
    return {NEXT} > window.start + 740;
}})()"""


def test_scene_orientation_is_the_right_way_round(browser: Browser, orientation: str) -> None:
    page = browser.open(f"{orientation}?{BARE}&orientation=head-up")
    page.wait(f"{NEXT} > 0")
    page.wait(WHOLE_SCAN)
    spots, faults = strong_spots(page), page.faults()
    page.close()
    distance = np.hypot(*spots.T)
    bearing_deg = (np.rad2deg(np.arctan2(spots[:, 0], -spots[:, 1])) + HEADING_DEG) % 360
    assert faults == []
    assert bearing_deg == pytest.approx([30, 120, 250], abs=3.9 / 4)  # a quarter of the beamwidth
    assert distance / distance.max() == pytest.approx([1 / 3, 2 / 3, 1], abs=PIXELS / distance.max())


def test_a_line_that_is_too_thin(browser: Browser, orientation: str) -> None:
    """Half of what the page takes unthinned arrives: it asks for less, is a little behind for a while, and says nothing then."""
    page = browser.open(f"{orientation}?{BARE}", first=CLOCK)
    page.call("Network.enable")
    page.wait(f"{CONNECTED} && Number(document.getElementById('rate-text').textContent) > 0")
    ask_time(page)
    page.call("Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=40_000, uploadThroughput=-1)
    page.wait("!document.getElementById('thinned-text').hidden")
    page.wait("!document.getElementById('banner').textContent.startsWith('Behind')")
    assert not page.faults()
    page.close()
