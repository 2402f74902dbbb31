"""What measures exported C lies beside the firmware, not in the package."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "firmware" / "measure"))
