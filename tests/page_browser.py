"""A real browser for page tests, and raw requests that no browser would send."""

import os
import shutil
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
DRIVER = os.environ.get("CHROMEDRIVER") or shutil.which("chromedriver")
needs_browser = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="chromium or chromedriver is not installed"
)
#: Longest wait for something that comes, s; generous, since machines are busy.
PATIENCE = 60
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage", "--window-size=1024,768",
)  # fmt: skip


@contextmanager
def browsing(folder: Path) -> Iterator[Any]:
    """Run a headless Chromium with a separate profile."""
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service

    options = Options()
    assert CHROMIUM is not None
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={folder}"):
        options.add_argument(flag)
    # Both paths are given: nothing is looked up or fetched.
    service = Service(executable_path=DRIVER)
    driver = webdriver.Chrome(options=options, service=service)
    try:
        yield driver
    finally:
        driver.quit()


def until(driver: Any, kind: Callable[[Any], Any]) -> Any:
    """Wait until a condition holds."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(driver, PATIENCE, poll_frequency=0.1).until(kind)


def text(driver: Any, element: str) -> str:
    """Return the text of an element by its id."""
    return str(driver.execute_script(f"return document.getElementById('{element}').textContent"))


def ask(
    port: int, path: str, host: str | None = None, address: str = "127.0.0.1", **headers: str
) -> tuple[int, str, bytes]:
    """Send a raw request. Return status, headers and body."""
    lines = [f"GET {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}"]
    lines += [f"{k.replace('_', '-')}: {v}" for k, v in headers.items()]
    with socket.create_connection((address, port), timeout=PATIENCE) as line:
        line.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        got = b""
        while b"\r\n\r\n" not in got and (more := line.recv(65536)):
            got += more
        head, _, body = got.partition(b"\r\n\r\n")
        # A socket that was opened stays open; anything else ends.
        while b" 101 " not in head and (more := line.recv(65536)):
            body += more
    return int(head.split()[1]), head.decode(), body


UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
}
