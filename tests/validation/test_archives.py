"""Archives that are not what they should be are refused in words, with the file, the array and the rule."""

import numpy as np
import pytest
from glenoid.inputs import InputError
from glenoid.validate.movements import load_npz
from made_movements import crowd, write_npz


@pytest.fixture
def arrays(tmp_path):
    write_npz(tmp_path / "made.npz", crowd(2, 2))
    return dict(np.load(tmp_path / "made.npz"))


SPOILED = {
    "data in millimetres": (lambda z: z | {"data": 1e3 * z["data"]}, "another unit"),
    "durations in milliseconds": (lambda z: z | {"meta_duration_s": 1e3 * z["meta_duration_s"]}, "another unit"),
    "negative durations": (lambda z: z | {"meta_duration_s": -z["meta_duration_s"]}, "duration"),
    "durations in words": (lambda z: z | {"meta_duration_s": np.array(["fast"] * 4)}, "meta_duration_s"),
    "lengths in millimetres": (lambda z: z | {"meta_lu_m": np.full(4, 300.0)}, "upper_arm_length_m"),
    "a column too few": (lambda z: z | {"data": z["data"][:, :-1]}, "data"),
    "flat data": (lambda z: z | {"data": z["data"][:, 0]}, "data"),
    "data of text": (lambda z: z | {"data": z["data"].astype(str)}, "data"),
    "offsets beyond the data": (lambda z: z | {"offsets": z["offsets"] + 1000}, "offsets"),
    "falling offsets": (lambda z: z | {"offsets": z["offsets"][::-1]}, "offsets"),
    "offsets with fractions": (lambda z: z | {"offsets": z["offsets"] + 0.5}, "offsets"),
    "a task too few": (lambda z: z | {"meta_task": z["meta_task"][:-1]}, "meta_task"),
    "no persons": (lambda z: {k: v for k, v in z.items() if k != "meta_subject"}, "subject"),
    "no elbow": (lambda z: z | {"columns": np.char.replace(z["columns"], "el_x", "ell_x")}, "el_x"),
    "no offsets": (lambda z: {k: v for k, v in z.items() if k != "offsets"}, "offsets"),
}


@pytest.mark.parametrize("case", SPOILED)
def test_spoiled_archive_is_refused_by_name(tmp_path, arrays, case):
    spoil, word = SPOILED[case]
    file = tmp_path / "spoiled.npz"
    np.savez(file, **spoil(arrays))
    with pytest.raises(InputError, match=word) as caught:
        load_npz(file)
    assert str(file) in str(caught.value)


def test_an_array_alone_is_no_archive(tmp_path):
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(InputError, match="not an archive"):
        load_npz(tmp_path / "array.npy")
