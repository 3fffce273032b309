"""What the architecture tests read: the files of the repository, without build products."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SKIPPED = {"build", ".git", "__pycache__", ".mypy_cache", ".ruff_cache", ".pytest_cache", ".hypothesis", ".venv"}
TEXT = {".cpp", ".hpp", ".h", ".py", ".sh", ".md", ".txt", ".cmake", ".yaml", ".xml", ".json", ".toml", ".map", ".lcm"}


def files_of(room: str, *suffixes: str) -> list[Path]:
    """Files under a folder of the root ("." for all), by suffix (all if none)."""
    found = (path for path in sorted((ROOT / room).rglob("*")) if path.is_file())
    kept = (path for path in found if not SKIPPED & set(path.relative_to(ROOT).parts))
    return [path for path in kept if not suffixes or path.suffix in suffixes]


def name_of(path: Path) -> str:
    """Path from the root, with forward slashes."""
    return path.relative_to(ROOT).as_posix()
