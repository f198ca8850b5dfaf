import subprocess
import sys

import numpy as np
import pytest

from gui import palette


def test_segment_colours_are_stable_by_index_and_distinct():
    few, many = palette.segment_colours(5), palette.segment_colours(256)
    assert (few == many[:5]).all()
    assert len(np.unique(many, axis=0)) == 256
    assert (palette.segment_colours(257)[256] == many[0]).all()


def test_the_table_is_what_glasbey_makes():
    glasbey = pytest.importorskip("glasbey")
    made = glasbey.extend_palette(
        list(palette.RESERVED), palette_size=261, grid_size=32, lightness_bounds=(45, 80), chroma_bounds=(20, 44),
        hue_bounds=(0, 360), colorblind_safe=True, optimize_palette=False)[5:]  # fmt: skip
    made = np.array([palette.rgb(colour) for colour in made[:24]], int)
    assert np.abs(made - palette.segment_colours(24)).max() <= 8


def test_first_colours_differ_from_paper_and_judgements():
    first = palette.segment_colours(20).astype(int)
    for reserved in palette.RESERVED:
        assert np.linalg.norm(first - palette.rgb(reserved), axis=1).min() > 30


def test_importing_the_palette_loads_neither_qt_nor_glasbey():
    code = "import sys, gui.palette; print(sorted(m for m in ('PySide6', 'glasbey', 'vtkmodules') if m in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "[]"


def contrast(a: str, b: str) -> float:
    def luminance(colour: str) -> float:
        c = palette.rgb(colour) / 255
        return np.where(c <= 0.03928, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]

    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("dark", [False, True])
def test_text_and_judgements_can_be_read_on_their_paper(dark):
    theme = palette.theme(dark)
    for ground in (theme.paper, theme.panel, theme.raised):
        assert contrast(theme.ink, ground) > 7
        assert contrast(theme.soft_ink, ground) > 4.5
    for state in ("correct", "wrong", "tie", "undecided"):
        assert contrast(theme.state(state), theme.paper) > 3 or state == "undecided"


def test_apply_theme_sets_the_palette_of_the_application(qapp):
    for dark in (True, False):
        theme = palette.apply_theme(qapp, dark)
        assert qapp.palette().base().color().name().upper() == theme.paper
        assert theme.accent in qapp.styleSheet()
