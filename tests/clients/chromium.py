"""Drives a headless Chromium by its DevTools protocol: just enough to open a page, ask it things and look at it."""

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

CHROMIUM = Path("/usr/bin/chromium")
PATIENCE = 60.0  # s for any one answer; two busy cores draw WebGL in software
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
    "--force-color-profile=srgb", "--remote-debugging-port=0",
]  # fmt: skip
# A page draws some 15 times a second, not 60: WebGL in software is most of what pages cost.
SLOWER = (
    "{ const soon = requestAnimationFrame; window.requestAnimationFrame = (draw) => setTimeout(() => soon(draw), 50); }\n"
)


def until(condition: str) -> str:
    """A promise of "" once an expression is true in a page, or of the page's text when it does not become so."""
    return f"""new Promise((done) => {{
      const end = performance.now() + {PATIENCE * 750};
      const look = () => {{
        let met = false;
        try {{ met = {condition}; }} catch {{ /* not there yet */ }}
        if (met) done("");
        else if (performance.now() > end) done(document.body.innerText);
        else setTimeout(look, 15);
      }};
      look();
    }})"""


def pixels(data: str) -> NDArray[np.int16]:
    """What a screenshot in base64 shows (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")).astype(np.int16)


class Remote:
    """A browser that obeys by a websocket, whose address it writes behind `marker`; `path`: below that."""

    def __init__(self, command: list[str], marker: str, path: str = "") -> None:
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        assert self._process.stderr is not None
        self._log = self._process.stderr
        address = next(line for line in self._log if marker in line).split(marker)[1].strip()
        self._line = ExitStack()
        # Between two tests nobody reads the events of open pages: a bounded queue would keep pongs from being read as well.
        connection = connect(address + path, max_size=None, max_queue=None, ping_interval=None, compression=None)
        self._socket: ClientConnection = self._line.enter_context(connection)
        self._numbers = itertools.count(1)
        self.events: list[dict[str, Any]] = []

    def answer(self, method: str, params: dict[str, Any], **more: Any) -> dict[str, Any]:
        """The answer to a method of the protocol; events that come in between are kept."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params, **more}))
        while True:
            answer: dict[str, Any] = json.loads(self._socket.recv(timeout=PATIENCE))
            if answer.get("id") == number:
                return answer
            self.events.append(answer)

    def gone(self) -> None:
        """Waits for the end of a browser that was told to end."""
        self._line.close()
        self._process.wait(PATIENCE)
        self._log.close()


class Browser(Remote):
    """One Chromium with a profile of its own under `folder`."""

    def __init__(self, folder: Path) -> None:
        super().__init__([str(CHROMIUM), *FLAGS, f"--user-data-dir={folder}", "about:blank"], "DevTools listening on ")

    def call(self, method: str, session: str | None = None, **params: Any) -> dict[str, Any]:
        """The result of a protocol method."""
        answer = self.answer(method, params, **({"sessionId": session} if session else {}))
        assert "error" not in answer, f"{method}: {answer['error']}"
        result: dict[str, Any] = answer["result"]
        return result

    def open(self, url: str, width: int = 900, height: int = 700, mobile: bool = False, first: str = "") -> "Page":
        """A new tab at `url`, width x height CSS pixels, one device pixel each; `first`: a script to run before its own."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        page = Page(self, target, session)
        for domain in ("Runtime", "Log", "Page"):
            page.call(f"{domain}.enable")
        page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)
        page.call("Page.addScriptToEvaluateOnNewDocument", source=SLOWER + first)
        page.call("Page.navigate", url=url)
        return page

    def close(self) -> None:
        """End the browser and wait for it."""
        self.call("Browser.close")
        self.gone()


class Page:
    """A tab."""

    def __init__(self, browser: Browser, target: str, session: str) -> None:
        self._browser, self._target, self._session = browser, target, session

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """The result of a protocol method on this tab."""
        return self._browser.call(method, self._session, **params)

    def ask(self, script: str) -> Any:
        """The value of an expression, or of the promise it gives."""
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait(self, condition: str) -> None:
        """Until the expression is true in the page; fails with the page's status when it does not become so."""
        seen = self.ask(until(condition))
        assert seen == "", f"never true: {condition}\n{seen}\n{self.faults()}"

    def text(self, selector: str) -> str:
        """The text of an element."""
        return str(self.ask(f"document.querySelector({json.dumps(selector)}).textContent"))

    def press(self, key: str) -> None:
        """Press and release a key, as a keyboard would."""
        named = {"Enter": "\r", "Escape": "", "ArrowRight": "", "ArrowLeft": "", "ArrowUp": "", "ArrowDown": "", "Tab": ""}
        written = named.get(key, key)
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **({"text": written} if written else {}))
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    def click(self, x: float, y: float) -> None:
        """A click of the left button at CSS pixels."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            button = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def look(self, keep: Path | None = None) -> NDArray[np.int16]:
        """What the screen shows (height, width, 3); `keep`: a PNG file to leave it in too."""
        data = self.call("Page.captureScreenshot", format="png")["data"]
        if keep is not None:
            keep.write_bytes(base64.b64decode(data))
        return pixels(data)

    def faults(self) -> list[str]:
        """Uncaught exceptions, errors on the console and everything the content security policy blocked."""
        faults = []
        for event in self._browser.events:
            if event.get("sessionId") != self._session:
                continue
            if event["method"] == "Runtime.exceptionThrown":
                faults.append(str(event["params"]["exceptionDetails"]))
            if event["method"] == "Runtime.consoleAPICalled" and event["params"]["type"] == "error":
                faults.append(str(event["params"]["args"]))
            if event["method"] == "Log.entryAdded" and event["params"]["entry"]["level"] == "error":
                faults.append(f"{event['params']['entry']['text']} {event['params']['entry'].get('url', '')}")
        return faults

    def close(self) -> None:
        """Shut the tab."""
        self._browser.call("Target.closeTarget", targetId=self._target)
