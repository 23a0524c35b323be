"""``python -m pitchopt`` is the program ``pitchopt``."""

from __future__ import annotations

import sys

from pitchopt.cli import main

if __name__ == "__main__":
    sys.exit(main())
