"""A page in headless Chromium, driven by the DevTools protocol over pipes."""

import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
"""A browser, if one is installed."""

OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--window-size=1400,1000",
    "--remote-debugging-pipe",
)

PATIENCE = 120.0
"""Longest time that a command may take [s]."""


class Browser:
    """A page in a browser of its own.

    Attributes:
        requests: addresses of all that was requested, besides the page itself and what it holds.
        faults: errors of the console.
    """

    def __init__(self, page: Path, profile: Path):
        """Open a page. Args: profile, a new folder for what the browser writes."""
        assert CHROMIUM is not None
        self.requests: list[str] = []
        self.faults: list[str] = []
        self._count, self._text, self._page = 0, b"", page.resolve().as_uri()
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()

        def connect() -> None:
            """The browser reads from descriptor 3 and writes to 4."""
            spare = [os.dup(to_browser), os.dup(from_browser)]
            for number, end in zip((3, 4), spare, strict=True):
                os.dup2(end, number)

        self._process = subprocess.Popen(
            [CHROMIUM, *OPTIONS, f"--user-data-dir={profile}"],
            preexec_fn=connect,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser)
        os.close(from_browser)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Page.navigate", url=self._page)
        self.wait("document.readyState === 'complete'")

    _session: str | None = None

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)

    def call(self, method: str, **arguments: Any) -> dict[str, Any]:
        """The result of a command of the protocol."""
        self._count += 1
        command = {"id": self._count, "method": method, "params": arguments}
        command |= {"sessionId": self._session} if self._session else {}
        os.write(self._write, json.dumps(command).encode() + b"\0")
        while True:
            message = self._message()
            if message.get("id") == self._count:
                assert "error" not in message, message
                return dict(message["result"])

    def evaluate(self, code: str) -> Any:
        """The value of an expression of JavaScript."""
        result = self.call(
            "Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def wait(self, condition: str) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.evaluate(condition):
            assert time.monotonic() < end, condition
            time.sleep(0.05)

    def _message(self) -> dict[str, Any]:
        """The next message; events are noted."""
        while b"\0" not in self._text:
            assert select.select([self._read], [], [], PATIENCE)[0], "the browser does not answer"
            part = os.read(self._read, 2**20)
            assert part, "the browser has ended"
            self._text += part
        text, _, self._text = self._text.partition(b"\0")
        message: dict[str, Any] = json.loads(text)
        given = message.get("params", {})
        match message.get("method"):
            case "Network.requestWillBeSent":
                address = given["request"]["url"]
                self.requests += [address] * (
                    address != self._page and not address.startswith(("data:", "blob:"))
                )
            case "Runtime.exceptionThrown":
                self.faults.append(json.dumps(given["exceptionDetails"]))
            case "Runtime.consoleAPICalled" if given["type"] in ("error", "assert"):
                self.faults.append(json.dumps(given["args"]))
            case "Log.entryAdded" if given["entry"]["level"] == "error":
                self.faults.append(given["entry"]["text"])
        return message
