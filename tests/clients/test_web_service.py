"""The page against the real service: it requests the token, keeps it, and reconnects after the service was killed."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.request import Request, urlopen

import pytest

from tests.clients.chromium import Browser
from tests.clients.conftest import QUICK
from tests.clients.screen import BARE, BROWSER

pytestmark = BROWSER

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


@pytest.fixture
def serve() -> Iterator[Serve]:
    services: list[subprocess.Popen[str]] = []

    def start(*options: str) -> tuple[str, "subprocess.Popen[str]"]:
        command = [sys.executable, "-m", "radar_service", "serve", "orientation", "--pace", "4", *options]
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
    address, service = serve("--port", "0", *files)
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
    serve("--port", port, *files)
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
