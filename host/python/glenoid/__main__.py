"""`python -m glenoid` is the command line."""

import sys

from glenoid.cli import main

sys.exit(main())
