"""Recordings for `glenoid replay` that anybody wrote: read, or refused in words. The first byte says which kind of file.

With atheris (libFuzzer for Python, `pip install atheris`), three minutes from the corpus:

    python tests/bus/fuzz_recordings.py -max_total_time=180 FOUND_FOLDER tests/bus/corpus/recordings
"""

import importlib
import sys
import tempfile
from pathlib import Path

from glenoid import recording
from glenoid.inputs import InputError

KINDS = {b"c": ".csv", b"j": ".json", b"l": ".log"}
FOLDER = tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None)


def run(data):
    """One file. Whatever is read is a motion: checked here once more."""
    path = Path(FOLDER.name, "a" + KINDS.get(data[:1], ".csv"))
    path.write_bytes(data[1:])
    try:
        motion = recording.read_recording(path)
    except InputError:
        return
    assert motion.position_rad.shape == motion.velocity_rad_per_s.shape
    assert len(motion.time_s) == len(motion.position_rad) >= 2
    assert 1 <= motion.joints <= 16
    assert motion.time_s[0] == 0.0


if __name__ == "__main__":
    import atheris

    with atheris.instrument_imports(include=["glenoid.recording"]):
        importlib.reload(recording)
    atheris.Setup(sys.argv, run)
    atheris.Fuzz()
