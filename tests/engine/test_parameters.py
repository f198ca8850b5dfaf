"""Parameters are declared once, and everything else is derived."""

import json

import pytest

from engine.errors import BadInput, BadParameter
from engine.parameters import assignments, declared, read_values
from engine.shapes.parameters import DEFAULT_PRESET, PRESETS, MatchParameters, preset


def test_every_parameter_is_fully_declared():
    for info in declared(MatchParameters):
        assert info.doc.endswith(".")
        assert info.group
        if info.kind in ("real", "integer"):
            assert info.low is not None
            assert info.low <= info.default <= info.high
        if info.kind == "choice":
            assert info.default in info.choices


def test_the_presets_hold_the_numbers_of_the_thesis():
    rigid, bent = preset("thesis-rigid"), preset("thesis-nonrigid")
    assert (rigid.delta_1, rigid.delta_2, rigid.K, rigid.c_0, rigid.lfd_threshold) == (0.2, 0.8, 7, 0.7, 0.8)
    assert (bent.delta_1, bent.delta_2) == (0.8, 0.2)
    assert preset("thesis-rigid-size").differences(rigid).keys() == {"size_weight"}
    assert DEFAULT_PRESET in PRESETS


def test_texts_are_converted():
    changed = preset("top-down").changed(K="9", voting="false", agree_from="0.5")
    assert (changed.K, changed.voting, changed.agree_from) == (9, False, 0.5)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"K": "99"}, ["'K'", "99", "from 1 to 30"]),
        ({"delta_1": "wide"}, ["'delta_1'", "a number from 0 to 1"]),
        ({"mode": "fast"}, ["'mode'", "literal", "beam"]),
        ({"voting": "perhaps"}, ["'voting'", "true or false"]),
        ({"gamma": "1"}, ["'gamma'", "no parameter", "delta_1"]),
        ({"c_0": "nan"}, ["'c_0'"]),
    ],
)
def test_wrong_values_get_one_sentence(values, words):
    with pytest.raises(BadParameter) as error:
        preset("top-down").changed(**values)
    text = str(error.value)
    assert "\n" not in text
    assert all(word in text for word in words)


def test_unknown_preset_names_those_that_exist():
    with pytest.raises(BadParameter, match="thesis-rigid"):
        preset("fastest")


def test_assignments():
    assert assignments(["K=3", " c_0 = 0.5 "]) == {"K": "3", "c_0": "0.5"}
    with pytest.raises(BadParameter, match="NAME=VALUE"):
        assignments(["K"])


def test_a_written_parameter_file_gives_the_same_parameters(tmp_path):
    values = preset("thesis-nonrigid").changed(K=3)
    file = tmp_path / "parameters.json"
    file.write_text(json.dumps(values.model_dump()))
    assert MatchParameters().changed(**read_values(file)) == values


@pytest.mark.parametrize("content", ["", "{", "[1]", "\x00"])
def test_damaged_parameter_files_are_refused(tmp_path, content):
    file = tmp_path / "parameters.json"
    file.write_text(content)
    with pytest.raises(BadInput, match=r"parameters\.json"):
        read_values(file)
