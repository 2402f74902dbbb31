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


def test_a_camera_is_compared_with_the_strips(tmp_path, capsys, recording):
    contacts = tmp_path / "contacts.csv"
    lines = ["pinch,finger,time_s"]
    for number in range(6):
        for finger, sample in (("index", 2000), ("thumb", 2090)):
            late = 0.05 * (number == 4)
            time = 100.0 + (5000 * number + sample) / LAYOUT.rate + late
            lines.append(f"{number},{finger},{np.ceil(time * 960) / 960}")
    contacts.write_text("\n".join([*lines, "77,thumb,3.0", ""]))
    assert main(["camera", str(recording), "--times", str(contacts), "--fps", "960"]) == 0
    output = capsys.readouterr().out
    assert "12 in both lists" in output
    assert "83.3 % within one frame of 1.04 ms" in output
    assert output.count("disagrees   pinch 4") == output.count("disagrees") == 2
    assert "left out    pinch 77, thumb" in output


def test_a_list_that_does_not_fit_is_refused(tmp_path, capsys, recording):
    contacts = tmp_path / "contacts.csv"
    contacts.write_text("pinch,finger,time_s\n77,index,1.0\n")
    assert main(["camera", str(recording), "--times", str(contacts)]) == 2
    assert "check the pinch numbers" in capsys.readouterr().err
