"""Path of the measuring scripts, which are stored with the firmware."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "firmware" / "measure"))
