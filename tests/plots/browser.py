"""A headless Chromium driven over its debugging pipe, for the tests of pages: no package, no network."""

import base64
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "chrome")
OPTIONS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars")
PATIENCE = 60  # seconds for an answer


def program():
    """The browser's program, or None."""
    return next(filter(None, map(shutil.which, PROGRAMS)), None)


class Browser:
    """One page at a time; what it says on its console, and errors of its scripts, are in `said`."""

    def __init__(self, folder):
        down, self.send_end = os.pipe()
        self.receive_end, up = os.pipe()
        command = f'exec "$0" "$@" 3<&{down} 4>&{up}'
        words = [program(), *OPTIONS, f"--user-data-dir={folder}", "--remote-debugging-pipe", "about:blank"]
        self.process = subprocess.Popen(
            ["bash", "-c", command, *words], pass_fds=(down, up), stderr=subprocess.DEVNULL
        )
        os.close(down)
        os.close(up)
        self.number, self.waiting, self.said, self.session = 0, b"", [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def close(self):
        """End it."""
        self.process.terminate()
        self.process.wait(PATIENCE)
        os.close(self.send_end)
        os.close(self.receive_end)

    def call(self, method, **params):
        """The result of a command of the protocol."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.send_end, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def _next(self):
        while b"\0" not in self.waiting:
            ready, _, _ = select.select([self.receive_end], [], [], PATIENCE)
            assert ready, "the browser does not answer"
            self.waiting += os.read(self.receive_end, 1 << 16)
        message, _, self.waiting = self.waiting.partition(b"\0")
        return json.loads(message)

    def _note(self, event):
        method, params = event.get("method"), event.get("params", {})
        if method in ("Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"):
            self.said.append(json.dumps(params)[:500])
        if method == "Network.requestWillBeSent":
            self.said += [] if params["request"]["url"].startswith("file:") else [params["request"]["url"]]

    def open(self, path, width=1200, height=900):
        """Show a file in a window of this size [px]."""
        self.said.clear()
        self.size(width, height)
        self.call("Page.navigate", url=Path(path).absolute().as_uri())
        until = time.monotonic() + PATIENCE
        while not self.value("document.readyState === 'complete' && !!document.querySelector('canvas')"):
            assert time.monotonic() < until, f"{path} does not load: {self.said}"
            time.sleep(0.05)

    def size(self, width, height=900):
        """Give the window another size [px]."""
        window = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **window)

    def value(self, expression):
        """What an expression comes to on the page."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def settle(self):
        """Wait until the page has drawn."""
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def mouse(self, kind, x, y, **more):
        """A mouse event at a place of the window [px]: Moved, Pressed, Released, Wheel."""
        self.call("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, **more)
        self.settle()

    def key(self, key):
        """Press a key."""
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key)
        self.settle()

    def box(self, selector, number=0):
        """Left, top, width and height of an element [px]."""
        found = f"document.querySelectorAll({selector!r})[{number}].getBoundingClientRect()"
        return self.value(f"(() => {{const b = {found}; return [b.left, b.top, b.width, b.height]}})()")

    def shown(self):
        """The data attributes of the page."""
        return json.loads(self.value("JSON.stringify(document.querySelector('main').dataset)"))

    def picture(self, path):
        """Write what the window shows to a PNG file."""
        data = self.call("Page.captureScreenshot", captureBeyondViewport=False)["data"]
        Path(path).write_bytes(base64.b64decode(data))
