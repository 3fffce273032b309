"""Where the shipped files are."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "host/examples/reach_to_head.yaml"
