"""Command ``firstcontact label``: page on which a person confirms contacts."""

from __future__ import annotations

import getpass
import webbrowser
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Option


@dataclass(frozen=True)
class Label:
    """Confirm contacts on a page by keyboard; the original recordings stay as they are."""

    paths: Annotated[tuple[Path, ...], Option(positional=True)]
    """Recordings, or folders of them."""
    out: Path
    """Folder for new recordings and the labels; run it again to continue."""
    by: str = ""
    """Name of the person who labels; your user name by default."""
    port: int = 0
    """TCP port of the page on this machine; 0 takes a free one."""
    finish: bool = False
    """Write recordings from the labels confirmed so far, without the page."""
    no_browser: bool = False
    """Print the address of the page, and open no browser."""

    def run(self) -> None:
        from firstcontact.cli.stopping import stop_on_signals
        from firstcontact.collect.label_result import Labeller
        from firstcontact.collect.label_session import Session, open_recordings
        from firstcontact.core import ArgumentError
        from firstcontact.core.installation import installed_versions

        if not self.paths:
            raise ArgumentError("nothing to label: give recordings, or folders of them")
        name = " ".join(self.by.split()) or _name()
        version = installed_versions()["firstcontact"]
        by = Labeller(name, f"{datetime.now(UTC):%Y-%m-%d}", f"firstcontact label {version}")
        recordings = open_recordings(self.paths)
        session = Session(recordings, self.out, by, is_new_allowed=not self.finish)
        try:
            print(f"{len(session.marks)} onsets to label; {session.earlier}")
            if self.finish:
                for line in session.finish():
                    print(line)
                return
            from firstcontact.collect.label_session import LabelServer

            server = LabelServer(session, self.port)
            print(f"label on {server.url} (Ctrl-C ends; the labels are kept)", flush=True)
            with stop_on_signals() as stop:
                stop.gently = True
                server.run(
                    lambda: not self.no_browser and webbrowser.open(server.url),
                    lambda: stop.requested,
                )
                stop.gently = False
            if not session.written:
                raise KeyboardInterrupt(
                    "the new recordings are not written yet: run the same command to continue"
                )
            for path in session.written:
                print(f"written to {path}")
        finally:
            session.close()


def _name() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return "somebody"
