import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import Block, Contact, Finger, fingertip_layout
from firstcontact.recording import Header, PinchMark, RecordingWriter

LAYOUT = fingertip_layout()


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "session-1.mcap"
    with RecordingWriter(path, Header(LAYOUT, "synthetic")) as writer:
        for number in range(6):
            start = 5000 * number
            writer.write(Block(np.zeros((5000, 16), np.int16), start))
            truth = (
                Contact(Finger.INDEX, start + 2000, start + 2000),
                Contact(Finger.THUMB, start + 2090, start + 2090),
            )
            writer.mark(PinchMark(number, start, start + 4000, truth=truth))
    return path


def test_a_list_that_does_not_fit_is_refused(tmp_path, capsys, recording):
    contacts = tmp_path / "contacts.csv"
    contacts.write_text("pinch,finger,time_s\n77,index,1.0\n")
    assert main(["camera", str(recording), "--times", str(contacts)]) == 2
    assert "check the pinch numbers" in capsys.readouterr().err
