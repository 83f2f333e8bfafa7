"""`python -m vtank` is the command `vtank`."""

from __future__ import annotations

import sys

from vtank.cli import main

sys.exit(main())
