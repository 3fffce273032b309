"""The suite for real CAN interfaces: `test_vcan.py` starts it once, inside the network that with_vcan.py makes."""

import os

collect_ignore = [] if os.environ.get("WITH_VCAN") else ["inside"]
