"""`concord descriptors` from end to end, on a small generated pair and on files."""

import csv
import json

import numpy as np
import pytest

from engine.__main__ import main
from engine.evaluation.retrieval import retrieval
from engine.runs.pairs import LabelledPair
from engine.runs.retrieving import SINGLES, TOGETHER, custom_mix, true_partners, weighted
from engine.shapes.describing import describe
from engine.shapes.families import make_pair, write_pair
from engine.shapes.parameters import MatchParameters
from engine.shapes.proposing import EXACT, every_pair

FAST = ["--nodes", "16", "--set", "light_fields=1", "resolution=64", "--jobs", "1"]


def read(path):
    with path.open(encoding="utf-8", newline="") as handle:
        return list(csv.DictReader(handle))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two families with one pair each, as files."""
    target = tmp_path_factory.mktemp("collection")
    for family in ("lamps", "vases"):
        write_pair(target / family, f"{family}_000", make_pair(family, 5, segments=(5, 6)))
    return target


@pytest.fixture(scope="module")
def out(folder, tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setenv("CONCORD_CACHE", str(tmp_path_factory.mktemp("cache")))
    target = tmp_path_factory.mktemp("out") / "found"
    assert main(["descriptors", str(folder), "--out", str(target), "--mix", "lfd=1,phks=0.5", *FAST]) == 0
    patch.undo()
    return target


def test_every_descriptor_and_mix_is_in_the_tables_beside_chance(out):
    names = [mix.name for mix in (*SINGLES, *TOGETHER)] + ["1 lfd + 0.5 phks"]
    rows = read(out / "retrieval.csv")
    assert list(dict.fromkeys(row["descriptor"] for row in rows)) == names
    assert {row["set"] for row in rows} == {"all", "lamps", "vases"}
    assert {row["segments"] for row in rows} == {"all", "1", "2-3", "4+"}
    text = (out / "tables.md").read_text()
    for name in (*names, "chance"):
        assert text.count(f"| {name} |") == 2  # over all pairs, and by family
    assert "Weights of LFD + size + geodesic: lfd 1, size 2, centrality 4." in text
    assert json.loads((out / "parameters.json").read_text())["node_cap"] == 16
    page = (out / "report.html").read_text()
    assert "persistent HKS" in page
    assert (out / "tables.tex").read_text().count(r"\begin{tabular}") == 2


def test_the_figures_are_those_of_the_nodes(out):
    """The whole way again for one pair and one descriptor, in a few lines."""
    made = make_pair("lamps", 5, segments=(5, 6))
    parameters = MatchParameters(node_cap=16, light_fields=1, resolution=64)
    source, target = (describe(shape, parameters) for shape in (made.source, made.target))
    truth = true_partners(LabelledPair(made.source, made.target, made.source_label, made.target_label), source, target)
    distance = every_pair(source, target, EXACT).apart["d2"].reshape(truth.shape)
    small = [shape.measures.size[:-1] <= 0.97 for shape in (source, target)]
    distance, truth = distance[np.ix_(*small)], truth[np.ix_(*small)]
    parts = [retrieval(d, t, np.ones(len(d))) for d, t in ((distance, truth), (distance.T, truth.T))]
    figures, chance = (np.concatenate([getattr(part, x) for part in parts]) for x in ("figures", "chance"))
    row = next(r for r in read(out / "retrieval.csv") if (r["descriptor"], r["set"], r["segments"]) == ("D2", "lamps", "all"))
    assert int(row["queries"]) == len(figures)
    found = [float(row[name]) for name in ("top-1", "top-7", "mean average precision", "AUC")]
    assert found == pytest.approx(figures.mean(axis=0), rel=1e-4)
    expected = [float(row[f"chance of {name}"]) for name in ("top-1", "top-7", "mean average precision", "AUC")]
    assert expected == pytest.approx(chance.mean(axis=0), rel=1e-4)


def test_sizes_add_up_and_families_are_averaged(out):
    rows = {(r["descriptor"], r["set"], r["segments"]): r for r in read(out / "retrieval.csv")}
    for name in ("LFD, exact", "all"):
        parts = [int(rows[name, "all", size]["queries"]) for size in ("1", "2-3", "4+")]
        assert sum(parts) == int(rows[name, "all", "all"]["queries"])
        mean = np.mean([float(rows[name, family, "all"]["top-1"]) for family in ("lamps", "vases")])
        assert float(rows[name, "all", "all"]["top-1"]) == pytest.approx(mean, abs=1e-5)


def test_what_was_done_is_not_done_again(folder, out, capsys, monkeypatch):
    def never(*_, **__):
        raise AssertionError("this was there already")

    monkeypatch.setattr("engine.runs.retrieving.describe", never)
    before = (out / "tables.md").read_text()
    assert main(["descriptors", str(folder), "--out", str(out), "--mix", "lfd=1,phks=0.5", *FAST]) == 0
    assert (out / "tables.md").read_text() == before
    assert before in capsys.readouterr().out


def test_a_mix_has_the_weights_that_were_given_and_no_others():
    values = weighted(MatchParameters(), custom_mix("size=2,hks=0.5"))
    weights = {name: value for name, value in values.model_dump().items() if name.endswith("_weight") and value}
    assert weights == {"size_weight": 2.0, "hks_weight": 0.5}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--mix", "lfd"], "NAME=WEIGHT"),
        (["--mix", "colour=1"], "no descriptor named 'colour'"),
        (["--mix", "lfd=9"], "lfd_weight"),
        (["--mix", "lfd=0"], "above 0"),
        (["--nodes", "5"], "10 to 1000"),
        (["--jobs", "-1"], "--jobs"),
        (["--set", "K=ninety"], "'K'"),
        (["--set", "lfd_weight=3"], "'lfd_weight' here: every mix brings its own"),
    ],
)
def test_bad_input_gets_one_sentence(folder, tmp_path, capsys, options, words):
    assert main(["descriptors", str(folder), "--out", str(tmp_path / "out"), *options]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_not_there(tmp_path, capsys):
    assert main(["descriptors", str(tmp_path / "nothing"), "--out", str(tmp_path / "out")]) == 2
    assert "not there" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
