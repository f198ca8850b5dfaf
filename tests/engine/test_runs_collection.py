"""Which pairs a folder holds, in every layout, and one sentence for each folder that holds none."""

import numpy as np
import pytest
from world import LAMP, boxes

from engine.errors import BadInput, BadParameter
from engine.runs.collection import Layout, families, folder_collection, generated_collection, natural
from engine.runs.pairs import FilePair, MadePair, ShapeFiles, content, load_labelled, load_pair
from engine.shapes.families.collection import off_text

TRUTH = "\n".join(str(c) for c in np.repeat([0, 1, 1, 2, 3], 12)) + "\n"
ONE = "7\n" * 60


def put(folder, name, **ends):
    """A lamp NAME.off and label files with these endings; `_` in the name of an ending stands for a dot."""
    folder.mkdir(parents=True, exist_ok=True)
    shape = boxes(LAMP, name)
    (folder / f"{name}.off").write_text(off_text(shape.mesh))
    for end, text in ends.items():
        (folder / f"{name}.{end.replace('_', '.')}").write_text(text)


def labels(*counts):
    """Labels of the five boxes, equal within each group of boxes."""
    return "\n".join(map(str, np.repeat(np.repeat(np.arange(len(counts)), counts), 12))) + "\n"


FIVE, FOUR = labels(1, 1, 1, 1, 1), labels(1, 2, 1, 1)


def names(collection):
    return [(pair.family, pair.name) for pair in collection.pairs]


def test_couples_are_paired_and_sub_folders_are_families(tmp_path):
    for family in ("lamps", "big/lamps"):
        for name in ("x_1_a", "x_1_b", "x_2_a", "x_2_b"):
            put(tmp_path / family, name, seg=FIVE, sem=TRUTH)
    found = folder_collection(tmp_path, Layout())
    assert names(found) == [(f, f"x_{k}_a x_{k}_b") for f in ("big/lamps", "lamps") for k in (1, 2)]
    assert len(folder_collection(tmp_path, Layout(pairs="1")).pairs) == 2
    assert len(folder_collection(tmp_path, Layout(pairs="all", families=("lamps",))).pairs) == 6
    assert found.pairs[0].source.labels.endswith("x_1_a.seg")


def test_shapes_follow_each_other_by_their_numbers(tmp_path):
    for name in ("10", "9", "1", "2"):
        put(tmp_path, name, seg=FIVE, sem=TRUTH)
    assert [n for _, n in names(folder_collection(tmp_path, Layout()))] == ["1 2", "2 9", "9 10"]
    more = folder_collection(tmp_path, Layout(pairs="5"))
    assert [n for _, n in names(more)] == ["1 2", "2 9", "9 10", "1 9", "2 10"]
    everything = folder_collection(tmp_path, Layout(pairs="50"))
    assert len(everything.pairs) == 6
    assert everything.notes == (f"The family {tmp_path.name} has 6 pairs only.",)
    assert sorted(["b10", "b9", "a"], key=natural) == ["a", "b9", "b10"]


def test_two_segmentations_make_a_pair_another_one_when_turned_round(tmp_path):
    for name in ("1", "2", "3"):
        put(tmp_path, name, coarse_seg=FOUR, fine_seg=FIVE, sem=TRUTH)
    layout = Layout(".coarse.seg", ".fine.seg")
    assert [n for _, n in names(folder_collection(tmp_path, layout))] == ["1 2", "2 3"]
    every = folder_collection(tmp_path, layout._replace(pairs="all"))
    assert [n for _, n in names(every)] == ["1 2", "2 3", "1 3", "2 1", "3 2", "3 1"]
    pair = load_pair(every.pairs[3])
    assert (pair.source.segmentation.count, pair.target.segmentation.count) == (4, 5)
    with pytest.raises(BadInput, match=r"have names: coarse, fine; .* --case coarse-fine"):
        folder_collection(tmp_path, Layout())


def test_other_endings_and_another_truth(tmp_path):
    for name in ("wolf0", "wolf1"):
        put(tmp_path, name, over_seg=FIVE, seg=FOUR, symseg=TRUTH)
    found = folder_collection(tmp_path, Layout(".over.seg", ".seg", ".symseg"))
    pair = load_pair(found.pairs[0])
    assert (pair.source.segmentation.count, pair.target.segmentation.count) == (5, 4)
    assert pair.source_label.tolist() == [int(c) for c in TRUTH.split()]
    with pytest.raises(BadInput, match=r"no truth labels \(beside the meshes there are .over.seg, .seg, .symseg\)"):
        folder_collection(tmp_path, Layout())


def test_truth_alone_is_cut_at_random_by_the_seed(tmp_path):
    for name in ("1", "2"):
        put(tmp_path, name, sem=TRUTH)
    found = folder_collection(tmp_path, Layout(segments=(6, 6), seed=3)).pairs[0]
    assert (found.source.labels, found.source.seed, found.target.seed) == ("", 3, 4)
    one, again = load_pair(found), load_pair(found)
    assert one.source.segmentation.count == 6
    assert (one.source.segmentation.labels == again.source.segmentation.labels).all()
    assert "random cut" in one.source.notes[0]
    put(tmp_path, "1", seg=FIVE)
    put(tmp_path, "2", seg=FIVE)
    assert folder_collection(tmp_path, Layout(cut=True)).pairs[0].source.labels == ""


def test_a_shape_in_one_segment_is_left_out_and_named(tmp_path):
    for name, text in (("1", FIVE), ("2", ONE), ("3", FIVE), ("4", FIVE)):
        put(tmp_path, name, seg=text, sem=TRUTH)
    found = folder_collection(tmp_path, Layout())
    assert [n for _, n in names(found)] == ["3 4"]
    assert found.notes == (f"Left out of {tmp_path.name}: 2.seg has one single segment.",)
    assert len(folder_collection(tmp_path, Layout(pairs="3")).pairs) == 3


@pytest.mark.parametrize(
    ("ends", "sentence"),
    [
        ([{"sem": TRUTH, "seg": FIVE}, {"sem": TRUTH, "seg": "1\n2\n"}], "2 labels but .* has 60 faces"),
        ([{"sem": "1\n", "seg": FIVE}, {"sem": TRUTH, "seg": FIVE}], "1 labels but .* has 60 faces"),
        ([{"sem": TRUTH, "seg": FIVE}, {"seg": FIVE}], "2.off has no truth labels; add 2.sem"),
        ([{"sem": TRUTH, "a_seg": FIVE}, {"sem": TRUTH, "b_seg": FIVE}], "have names: a, b; .* --case a-b"),
        ([{"sem": TRUTH}, {"sem": TRUTH, "a_seg": FIVE}], "have names: a; .* --case a-a"),
        ([{"sem": TRUTH}, {"sem": TRUTH, "seg": FIVE}], "1.off has no segment labels; add 1.seg"),
        ([{"seg": FIVE}, {"seg": FIVE}], "have no truth labels"),
        ([{"sem": TRUTH, "seg": FIVE}], "holds no pair"),
        ([{"sem": TRUTH, "seg": ONE}, {"sem": TRUTH, "seg": FIVE}], r"holds no pair .*\(.*1.seg has one single segment\)"),
    ],
)
def test_a_folder_that_cannot_be_used_is_refused_in_one_sentence(ends, sentence, tmp_path):
    for number, one in enumerate(ends, start=1):
        put(tmp_path, str(number), **one)
    with pytest.raises(BadInput, match=sentence):
        folder_collection(tmp_path, Layout())


def test_folders_without_meshes_and_unknown_families(tmp_path):
    with pytest.raises(BadInput, match="is not there"):
        families(tmp_path / "nowhere")
    with pytest.raises(BadInput, match="holds no meshes"):
        families(tmp_path)
    (tmp_path / "file").write_text("x")
    with pytest.raises(BadInput, match="not a folder"):
        families(tmp_path / "file")
    put(tmp_path / "lamps", "1", seg=FIVE, sem=TRUTH)
    put(tmp_path / ".hidden", "1", seg=FIVE, sem=TRUTH)
    assert list(families(tmp_path)) == ["lamps"]  # and not .hidden
    with pytest.raises(BadInput, match="no family 'vases'; its families are lamps"):
        folder_collection(tmp_path, Layout(families=("vases",)))
    for pairs in ("0", "-3", "some", "1e3"):
        with pytest.raises(BadParameter, match="--pairs cannot be"):
            folder_collection(tmp_path, Layout(pairs=pairs))


def test_meshes_that_would_share_their_labels_are_refused(tmp_path):
    put(tmp_path, "1", seg=FIVE, sem=TRUTH)
    (tmp_path / "1.ply").write_text("another mesh of that name")
    with pytest.raises(BadInput, match=r"1.off and 1.ply would share their labels"):
        families(tmp_path)


def test_generated_pairs_have_a_seed_each_and_variants_in_turn():
    found = generated_collection(Layout(pairs="2", seed=50, families=("vases", "lamps")), ("touching", "welded"), "turned")
    assert [(p.family, p.seed, p.variant) for p in found.pairs] == [
        ("vases", 50, "touching"), ("vases", 52, "welded"), ("lamps", 51, "touching"), ("lamps", 53, "welded")]  # fmt: skip
    for layout, words in ((Layout(families=("boats",)), "shape family"), (Layout(pairs="all"), "as many pairs as wanted")):
        with pytest.raises(BadParameter, match=words):
            generated_collection(layout, ("touching",), "turned")


def test_what_a_pair_depends_on_changes_with_its_bytes(tmp_path):
    put(tmp_path, "1", seg=FIVE, sem=TRUTH)
    put(tmp_path, "2", seg=FOUR, sem=TRUTH)
    one, two = (ShapeFiles(*(str(tmp_path / f"{k}{end}") for end in (".off", ".sem", ".seg"))) for k in "12")
    before = content(FilePair("f", "n", one, two))
    assert content(FilePair("g", "m", one, two)) == before
    assert content(FilePair("f", "n", two, one)) != before
    (tmp_path / "2.sem").write_text(TRUTH.replace("3", "9"))
    assert content(FilePair("f", "n", one, two)) != before
    assert load_labelled(two)[1].max() == 9
    made = MadePair("lamps", "n", 3, "touching", (10, 16), "turned")
    assert content(made) != content(made._replace(seed=4))


def test_the_layouts_of_real_sets(real_shapes):
    vases = folder_collection(real_shapes / "princeton", Layout(".coarse.seg", ".fine.seg", families=("Vase",)))
    assert (len(vases.pairs), vases.notes) == (12, ("Left out of Vase: 363.coarse.seg has one single segment.",))
    wolves = folder_collection(real_shapes / "tosca", Layout(".over.seg", ".seg", ".symseg", pairs="20", families=("wolf",)))
    assert [n for _, n in names(wolves)] == [f"wolf{i} wolf{j}" for i, j in ((0, 1), (1, 2), (0, 2), (1, 0), (2, 1), (2, 0))]
    assert wolves.notes == ("The family wolf has 6 pairs only.",)
    with pytest.raises(BadInput, match=r"have names: coarse, fine, median; .* --case coarse-median"):
        folder_collection(real_shapes / "princeton", Layout())
    with pytest.raises(BadInput, match="have no truth labels"):
        folder_collection(real_shapes / "lamps", Layout())
