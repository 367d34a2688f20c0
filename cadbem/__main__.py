"""``python -m cadbem``."""

import sys

from cadbem.cli import main

sys.exit(main())
