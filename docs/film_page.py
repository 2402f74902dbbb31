"""Film the live page for the README: ``python docs/film_page.py docs/images/page.gif``.

The script runs the command of ``make live``. It opens the page in a headless Chromium
(``CHROMIUM``, ``CHROMEDRIVER``, or those on the path) and writes an animated GIF.
"""

from __future__ import annotations

import argparse
import io
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

#: Size of the window and width of the pictures, pixels; pictures per second; length of the film,
#: and time before it, s.
WINDOW, WIDTH, PACE, SECONDS, START = (1180, 885), 860, 6, 7.0, 12.0
#: Number of colours of the GIF.
COLOURS = 96


def pictures(folder: Path) -> list[Image.Image]:
    """Return the pictures that a viewer sees, six per second."""
    command = [sys.executable, "-m", "firstcontact.cli.main", "live", "--device", "twin", "--page"]
    with subprocess.Popen(
        [*command, "--hand", "twin", "--port", "0", "--seed", "3"], stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    ) as live:  # fmt: skip
        assert live.stderr is not None
        url = next(line.split("page: ")[1].strip() for line in live.stderr if "page: " in line)
        options = Options()
        options.binary_location = os.environ.get("CHROMIUM") or shutil.which("chromium") or ""
        size = f"--window-size={WINDOW[0]},{WINDOW[1]}"
        for flag in ("--headless", "--no-sandbox", "--disable-gpu", size, "--hide-scrollbars",
                     f"--user-data-dir={folder}"):  # fmt: skip
            options.add_argument(flag)
        path = os.environ.get("CHROMEDRIVER") or shutil.which("chromedriver")
        driver = webdriver.Chrome(options=options, service=Service(executable_path=path))
        try:
            driver.get(url)
            began = time.monotonic() + START
            frames = []
            while len(frames) < SECONDS * PACE:
                due = began + len(frames) / PACE
                time.sleep(max(0.0, due - time.monotonic()))
                picture = Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB")
                height = round(picture.height * WIDTH / picture.width)
                frames.append(picture.resize((WIDTH, height), Image.Resampling.LANCZOS))
        finally:
            driver.quit()
            live.send_signal(signal.SIGINT)
            live.communicate()
    return frames


def main() -> None:
    """Film the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    with tempfile.TemporaryDirectory() as folder:
        screenshots = pictures(Path(folder))
    palette = screenshots[len(screenshots) // 2].quantize(COLOURS, dither=Image.Dither.NONE)
    frames = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in screenshots]
    frames[0].save(
        out, save_all=True, append_images=frames[1:], duration=round(1000 / PACE), loop=0,
        optimize=True,
    )  # fmt: skip
    print(f"{out}: {len(frames)} pictures, {out.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
