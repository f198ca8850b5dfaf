"""The thesis's tables from a study's votes, through the command that people use."""

import csv

import pytest
from judging_world import CANDLE, LAMP, ONE_TO_ONE, VASE, identity, result, study_of

from annotation import study
from annotation.findings.thesistables import voted_precision
from annotation.server.publishing import publish
from engine.errors import BadInput
from engine.evaluation.averages import thesis_average
from gui.__main__ import main


@pytest.fixture
def file(tmp_path):
    """Two sets and two methods: of lamps 2 of 3 are right by top-down and 1 of 1 by SHED, of candles 1 of 1."""
    path = tmp_path / "votes.db"
    shed = result(((0,), (0,)), preset="shed", method="shed", layers=5)
    with study_of(path, result(*ONE_TO_ONE), shed, set_name="lamps") as handle:
        study.add_result(handle, result(((0,), (0,)), target=CANDLE, layers=4), set_name="candles")
        for (one, other), answer in zip(ONE_TO_ONE, ("correct", "correct", "wrong"), strict=True):
            study.record_vote(handle, identity(LAMP, one, VASE, other), "anna", answer)
        study.record_vote(handle, identity(LAMP, (0,), CANDLE, (0,)), "anna", "correct")
    return path


def test_precision_pairs_and_layers_of_each_method_and_set(file, tmp_path):
    found, modern = voted_precision(file)
    assert [tuple(f) for f in found] == [
        ("shed", "lamps", 1.0, 1, 5), ("top-down", "candles", 1.0, 1, 4), ("top-down", "lamps", pytest.approx(2 / 3), 1, 8)]  # fmt: skip
    assert len(modern.rows) == 4
    assert voted_precision(tmp_path) is None
    (tmp_path / "votes.concord").mkdir()
    file.rename(tmp_path / "votes.concord" / "study.db")
    assert voted_precision(tmp_path / "votes.concord")[0] == found


def test_the_command_makes_the_table_of_a_study(file, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["tables", "3.2", str(file), "--out", str(out)]) == 0
    mean, spread = thesis_average([100, 200 / 3], [1, 1])
    text = (out / "table-3.2.md").read_text()
    assert "| set | shed | top-down | pairs | layers |" in text
    assert f"| average | 100.0 % | {mean:.1f} % ({spread:.1f}) |  |  |" in text
    assert "Precision by majority of the votes" in text
    with (out / "table-3.2.csv").open(newline="") as handle:
        assert [row["precision"] for row in csv.DictReader(handle)] == ["1", "1", "0.666667"]
    assert {p.name for p in out.iterdir()} == {f"table-3.2.{end}" for end in ("md", "csv", "tex", "html")}
    for words in (["--methods", "shed"], ["--families", "lamps"]):
        assert main(["tables", "3.2", str(file), *words, "--out", str(out)]) == 2
        assert "leave out --methods" in capsys.readouterr().err


def test_a_study_without_shapes_is_refused(tmp_path):
    study.create_study(tmp_path / "empty.db", name="Empty").close()
    with pytest.raises(BadInput, match="no results of shapes"):
        voted_precision(tmp_path / "empty.db")
    (tmp_path / "text").write_text("not a study")
    with pytest.raises(BadInput):
        voted_precision(tmp_path / "text")


def test_a_study_on_a_server_is_counted_like_its_file(file, database, tmp_path, capsys):
    with study.open_study(file) as handle:
        publish(handle, database)
    assert main(["tables", "3.1", str(file), "--out", str(tmp_path / "file")]) == 0
    assert main(["tables", "3.1", database, "--out", str(tmp_path / "server")]) == 0
    assert (tmp_path / "file" / "table-3.1.csv").read_bytes() == (tmp_path / "server" / "table-3.1.csv").read_bytes()
    assert main(["tables", "3.1", database, "--methods", "shed", "--out", str(tmp_path / "none")]) == 2
    said = "".join(capsys.readouterr()) + (tmp_path / "server" / "table-3.1.md").read_text()
    assert "leave out --methods" in said
    assert "of-the-owner" not in said


def test_a_study_out_of_reach_is_one_sentence(tmp_path, capsys):
    assert main(["tables", "3.1", "postgresql://me:secret@127.0.0.1:9/lamps", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "cannot be reached" in said
    assert "secret" not in said
    assert not (tmp_path / "out").exists()
