"""Every Python process that tests start imports this first (see conftest.py).

They all simulate in C, so Warp is as if it were not installed: MJX, which Brax imports, would
import it, and its own code for it, in four seconds.
"""

import sys

sys.modules["warp"] = None  # type: ignore[assignment]
