"""The demonstration and its picture."""

import matplotlib as mpl
import pytest
from glenoid.demo import EXAMPLE
from glenoid.findings import warnings_for
from glenoid.inputs import load_reach
from glenoid.plot import STYLE, compose, draw_reach
from glenoid.reach import plan_reach


@pytest.fixture(scope="module")
def example():
    return plan_reach(load_reach(EXAMPLE))


def test_demo_tells_what_happened_and_draws(run, tmp_path):
    picture = tmp_path / "deep" / "reach.png"
    done = run("demo", "--picture", picture)
    assert done.code == 0
    for words in (
        "UE_ADLdatabase",
        "strict local minimum",
        "Glenoid.fmu",
        "Glenoid_fmi2.fmu",
        "difference from the core",
    ):
        assert words in done.out
    assert str(picture) in done.out.replace("\n", "")
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_every_axis_of_the_picture_says_its_unit(example):
    with mpl.rc_context(STYLE):
        figure = compose(example)
    assert len(figure.axes) == 6
    for axes in figure.axes:
        assert axes.get_title(loc="left")
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert label.endswith(")"), label


def test_views_are_to_scale(example):
    figure = compose(example)
    assert [axes.get_aspect() for axes in figure.axes[:2]] == [1.0, 1.0]


def test_warnings_are_in_the_picture(example, monkeypatch):
    from glenoid import plot

    monkeypatch.setattr(plot, "warnings_for", lambda reach: ["mind the step"])
    assert "WARNING: mind the step" in plot.headline(example)
    assert isinstance(warnings_for(example), list)


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_picture_comes_in_every_format(example, tmp_path, suffix):
    file = tmp_path / f"reach.{suffix}"
    draw_reach(example, file)
    assert file.stat().st_size > 10_000
