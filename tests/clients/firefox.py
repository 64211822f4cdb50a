"""Drives a headless Firefox by WebDriver BiDi (W3C): just enough to open a page, ask it things, type and look at it."""

import base64
import io
import itertools
import json
import subprocess
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from websockets.sync.client import ClientConnection, connect

from tests.clients.chromium import PATIENCE, until

FIREFOX = Path("/usr/bin/firefox-esr")
KEYS = {"ArrowRight": "\ue014"}  # as WebDriver names them
PREFERENCES = {  # nothing is fetched but the page
    "app.normandy.enabled": False, "app.update.auto": False, "browser.safebrowsing.malware.enabled": False,
    "browser.safebrowsing.phishing.enabled": False, "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False, "extensions.update.enabled": False,
    "network.captive-portal-service.enabled": False, "network.connectivity-service.enabled": False,
    "services.settings.server": "data:,#remote-settings-dummy/v1", "toolkit.telemetry.enabled": False,
    # One page in one process, drawn 15 times a second: three seconds of processor time less.
    "browser.aboutwelcome.enabled": False, "browser.newtab.preload": False, "browser.newtabpage.enabled": False,
    "browser.startup.page": 0, "dom.ipc.processPrelaunch.enabled": False, "fission.autostart": False,
    "layout.frame_rate": 15,
}  # fmt: skip


class Firefox:
    """One Firefox with a profile of its own under `folder`, and one page in it, width x height CSS pixels."""

    def __init__(self, folder: Path, width: int = 1100, height: int = 700) -> None:
        lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in PREFERENCES.items()]
        (folder / "user.js").write_text("\n".join(lines), encoding="utf-8")
        command = [str(FIREFOX), "--headless", "--no-remote", "--profile", str(folder), "--remote-debugging-port", "0"]
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        assert self._process.stderr is not None
        marker = "WebDriver BiDi listening on "
        self._log = self._process.stderr
        address = next(line for line in self._log if marker in line).split(marker)[1].strip()
        self._line = ExitStack()
        self._socket: ClientConnection = self._line.enter_context(
            connect(f"{address}/session", max_size=None, max_queue=None, ping_interval=None)
        )
        self._numbers = itertools.count(1)
        self.call("session.new", capabilities={})
        self._page: str = self.call("browsingContext.getTree")["contexts"][0]["context"]
        self.call("browsingContext.setViewport", context=self._page, viewport={"width": width, "height": height})

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """The result of a BiDi command; events that come in between are dropped."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._socket.recv(timeout=PATIENCE))
            if answer.get("id") == number:
                assert answer["type"] == "success", f"{method}: {answer}"
                result: dict[str, Any] = answer["result"]
                return result

    def open(self, url: str) -> None:
        """Loads a page."""
        self.call("browsingContext.navigate", context=self._page, url=url, wait="complete")

    def ask(self, script: str) -> Any:
        """The value of an expression, or of the promise it gives: plain data."""
        expression = f"Promise.resolve({script}).then((value) => JSON.stringify(value ?? null))"
        answer = self.call("script.evaluate", expression=expression, target={"context": self._page}, awaitPromise=True)
        assert answer["type"] == "success", answer
        return json.loads(answer["result"]["value"])

    def wait(self, condition: str) -> None:
        """Until the expression is true in the page; fails with the page's status when it does not become so."""
        seen = self.ask(until(condition))
        assert seen == "", f"never true: {condition}\n{seen}"

    def press(self, key: str) -> None:
        """Press and release a key, as a keyboard would."""
        actions = [{"type": kind, "value": KEYS.get(key, key)} for kind in ("keyDown", "keyUp")]
        self.call(
            "input.performActions", context=self._page, actions=[{"type": "key", "id": "keyboard", "actions": actions}]
        )

    def look(self) -> NDArray[np.int16]:
        """What the page shows (height, width, 3)."""
        data = base64.b64decode(self.call("browsingContext.captureScreenshot", context=self._page)["data"])
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(np.int16)

    def close(self) -> None:
        """End the browser and wait for it."""
        self.call("browser.close")
        self._line.close()
        self._process.wait(PATIENCE)
        self._log.close()
