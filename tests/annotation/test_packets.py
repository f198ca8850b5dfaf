"""Packets: one volunteer's items and nothing else, and nothing in them tells who proposed a match or which are checks."""

import json
import math
import sqlite3
import zlib
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from exchange_world import PARTS, ask, cells, content, diagonal, ids_of, match, run_of, strip, strip_study
from sqlalchemy import update

from annotation import study
from annotation.exchange.merging import merge_handles
from annotation.exchange.packets import make_packet
from annotation.records import Item
from annotation.storage import schema
from annotation.storage.blobs import keep_shapes, kept_shapes
from annotation.voting.answering import make_adjudicator
from engine.errors import BadInput, BadParameter

PNG = "iVBORw0KGgo="


def opened(path: Path) -> study.StudyHandle:
    return study.open_study(path, backup=False)


def test_a_packet_holds_what_its_volunteer_needs(tmp_path):
    with strip_study(tmp_path / "a.db", question="Same end?", guideline="Look twice.", unsure=False, votes=3) as whole:
        ids = ids_of(whole)
        ask(whole, dict(zip(ids, ("practice", "gold", *["judged"] * 4), strict=True)), reason="Both are first.")
        make_packet(whole, "anna", tmp_path / "p.db")
        order = [one.item_id for one in study.open_items(whole, "anna")]
        sides = [study.sides_swapped(study.volunteer(whole, "anna"), item) for item in order]
        told = study.about(whole)
    with opened(tmp_path / "p.db") as packet:
        about = study.about(packet)
        assert (about.id, about.name, about.question, about.guideline) == (told.id, "Strips", "Same end?", "Look twice.")
        assert (about.unsure, about.votes, about.settings, about.seed) == (False, 0, {"packet": "anna"}, "")
        assert packet.volunteer == "anna"
        assert [one.item_id for one in study.open_items(packet, "anna")] == order
        assert [one.round for one in study.open_items(packet, "anna")] == [0, 1, 1, 1, 1, 1]
        assert [study.sides_swapped(study.volunteer(packet, "anna"), item) for item in order] == sides
        assert study.practice(packet) == {ids[0]: study.Practice("correct", "Both are first.")}
        for item in study.items(packet, "anna"):
            assert all(len(kept_shapes(packet, side)) == 1 for side in item.payload.values())
        assert study.progress(packet, "anna").total == 5
    held = content(tmp_path / "p.db")
    assert [len(held[name]) for name in ("run", "run_match", "assignment", "forgotten", "event")] == [0] * 5
    assert [len(held[name]) for name in ("volunteer", "asked", "item", "blob")] == [1, 6, 6, 2]


def test_own_votes_that_were_taken_back_are_in_it_and_nobody_elses(tmp_path):
    with strip_study(tmp_path / "a.db") as whole:
        first, second = ids_of(whole)[:2]
        for code in ("anna", "bert"):
            study.record_vote(whole, second, code, "wrong")
            study.record_vote(whole, first, code, "wrong", comment=f"{code} doubts it")
            study.undo_vote(whole, code)
        make_packet(whole, "anna", tmp_path / "p.db")
        events = content(tmp_path / "p.db")["event"]
        assert [(row[1], row[3]) for row in sorted(events, key=lambda row: row[8])] == [("vote", "anna"), ("retraction", "anna")]
        with opened(tmp_path / "p.db") as packet:
            assert second not in ids_of_packet(packet)
            study.record_vote(packet, first, "anna", "correct")
            merge_handles(packet, whole)
        assert study.answers(whole, "anna") == {first: "correct", second: "wrong"}


def ids_of_packet(packet: study.StudyHandle) -> set[str]:
    return {item.id for item in study.items(packet, packet.volunteer)}


def test_only_its_volunteer_may_vote_in_it(tmp_path):
    with strip_study(tmp_path / "a.db") as whole:
        make_packet(whole, "anna", tmp_path / "p.db")
        item = ids_of(whole)[0]
    with opened(tmp_path / "p.db") as packet:
        for forbidden in (
            lambda: study.record_vote(packet, item, "bert", "correct"),
            lambda: study.record_votes(packet, "bert", {item: "correct"}),
            lambda: study.undo_vote(packet, "bert"),
            lambda: study.open_items(packet, "bert"),
        ):
            with pytest.raises(BadInput, match="for volunteer anna alone"):
                forbidden()
        study.record_vote(packet, item, "anna", "correct")
    assert [row[0] for row in content(tmp_path / "p.db")["volunteer"]] == ["anna"]


def test_packets_share_the_work(tmp_path):
    """With one vote an item nobody gets what is in somebody else's packet."""
    with strip_study(tmp_path / "a.db", votes=1) as whole:
        one = make_packet(whole, "anna", tmp_path / "anna.db", items=4)
        other = make_packet(whole, "bert", tmp_path / "bert.db", items=4)
        assert (one.items, other.items) == (4, 2)
        with pytest.raises(BadInput, match="Nothing is open for carl"):
            make_packet(whole, "carl", tmp_path / "carl.db")
        with opened(one.path) as a, opened(other.path) as b:
            assert ids_of_packet(a) | ids_of_packet(b) == {item.id for item in study.items(whole, "anna")}


def test_a_lost_packet_is_made_again_and_the_next_one_is_new(tmp_path):
    with strip_study(tmp_path / "a.db", votes=1) as whole:
        lost = make_packet(whole, "anna", tmp_path / "lost.db", items=2)
        again = make_packet(whole, "anna", tmp_path / "again.db")
        with opened(lost.path) as one, opened(again.path) as other:
            assert ids_of_packet(one) == ids_of_packet(other)
            for item in ids_of_packet(other):
                study.record_vote(other, item, "anna", "correct")
            merge_handles(other, whole)
        following = make_packet(whole, "anna", tmp_path / "next.db")
        with opened(following.path) as packet:
            assert following.items == 4
            assert not ids_of_packet(packet) & set(study.answers(whole, "anna"))


def test_an_adjudicator_gets_what_is_disputed(tmp_path):
    with strip_study(tmp_path / "a.db", votes=2) as whole:
        ids = ids_of(whole)
        for code, answer in (("anna", "correct"), ("bert", "wrong"), ("carl", "unsure")):
            study.record_vote(whole, ids[0], code, answer)
        make_adjudicator(whole, "dora")
        made = make_packet(whole, "dora", tmp_path / "p.db")
        with opened(made.path) as packet:
            assert [one.item_id for one in study.open_items(packet, "dora")] == [ids[0]]
            study.record_vote(packet, ids[0], "dora", "correct")
            merge_handles(packet, whole)
        assert study.majority(whole)[ids[0]].verdict == "correct"
        assert study.volunteer(whole, "dora").adjudicates


def test_shapes_are_taken_from_their_files_or_the_packet_is_refused(tmp_path):
    from engine.shapes.meshfile import load_shape

    for name, seed in (("a", 1), ("b", 2)):
        shape = strip(seed)
        rows = [f"{x!r} {y!r} {z!r}" for x, y, z in shape.mesh.vertices.tolist()]
        faces = [f"3 {a} {b} {c}" for a, b, c in shape.mesh.faces.tolist()]
        (tmp_path / f"{name}.off").write_text("\n".join(["OFF", f"{len(rows)} {len(faces)} 0", *rows, *faces]) + "\n")
        (tmp_path / f"{name}.seg").write_text("\n".join(str(label) for label in shape.segmentation.labels) + "\n")
    a, b = (load_shape(tmp_path / f"{name}.off") for name in "ab")
    with study.create_study(tmp_path / "study.db", name="Files") as whole:
        study.add_run(whole, run_of(a, b, diagonal(a, b)))
        (tmp_path / "b.off").rename(tmp_path / "away.off")
        with pytest.raises(BadInput, match=r"b\.off") as told:
            make_packet(whole, "anna", tmp_path / "p.db")
        assert str(tmp_path) not in str(told.value)
        assert not (tmp_path / "p.db").exists()
        assert content(tmp_path / "study.db")["assignment"] == []
        (tmp_path / "away.off").rename(tmp_path / "b.off")
        assert make_packet(whole, "anna", tmp_path / "p.db").items == PARTS
        assert len(content(tmp_path / "study.db")["blob"]) == len(content(tmp_path / "p.db")["blob"]) == 2


def test_what_cannot_be_is_refused_and_nothing_is_handed_out(tmp_path):
    with strip_study(tmp_path / "a.db") as whole:
        with pytest.raises(BadParameter, match="at least 1"):
            make_packet(whole, "anna", tmp_path / "p.db", items=0)
        with pytest.raises(BadParameter, match="no volunteer code"):
            make_packet(whole, "../anna", tmp_path / "p.db")
        with pytest.raises(BadInput, match="exists already"):
            make_packet(whole, "anna", tmp_path / "a.db")
        with pytest.raises(BadInput, match="cannot be written"):
            make_packet(whole, "anna", tmp_path / "no" / "p.db")
        assert content(tmp_path / "a.db")["assignment"] == []
        made = make_packet(whole, "anna", tmp_path / "p.db")
    with opened(made.path) as packet, pytest.raises(BadInput, match="for anna alone"):
        make_packet(packet, "anna", tmp_path / "q.db")


MARKS = {
    "method": "mk-method-4711", "preset": "mk-preset-4711", "parameter": "mk-param-4711", "set": "mk-set-4711",
    "run file": "mk-runfile-4711", "item file": "mk-itemfile-4711", "volunteer": "mk-bert-4711", "comment": "mk-comment-4711",
    "stratum": "mk-stratum-4711", "gold reason": "mk-gold-4711", "settings": "mk-settings-4711", "presentation": "mk-shown-4711",
    "source": "mk-source-4711", "seed": "mk-seed-4711", "score": "0.47114711",
}  # fmt: skip


GOLD_STAMP = "2026-06-06T06:06:06.000000+00:00"


def marked_study(path: Path) -> study.StudyHandle:
    """A study that holds a mark in everything that a volunteer may not know."""
    a, b = strip(1), strip(2)
    files = (f"/data/{MARKS['item file']}/a.off", f"{MARKS['item file']}.off")
    items = [Item(i.id, i.kind, dict(i.payload) | {"method": MARKS["source"]}) for i in diagonal(a, b, 20, files)]
    noted = {name: side | {"note": MARKS["source"]} for name, side in match(a, (0, 1), b, (3,), files).payload.items()}
    items[3] = Item(items[3].id, "shape", noted)
    puzzle = {"size": [2, 1], "pieces": [{"piece": p, "x": k, "y": 0, "png": PNG, "file": MARKS["source"]} for k, p in enumerate("de")]}
    items.append(Item("f" * 64, "puzzle", puzzle))
    handle = study.create_study(path, name="Strips", seed=MARKS["seed"], settings={"told": MARKS["settings"]}, votes=2)
    run = run_of(a, b, items, (MARKS["run file"], MARKS["run file"]), method=MARKS["method"], preset=MARKS["preset"],
                 parameters={MARKS["parameter"]: 1}, set_name=MARKS["set"])  # fmt: skip
    study.add_run(handle, run)
    keep_shapes(handle, (a, b, strip(9)))
    with handle.writing() as connection:
        connection.execute(update(schema.run_match).values(score=float(MARKS["score"])))
    ids = [item.id for item in items]
    ask(handle, dict.fromkeys(ids[:14], "judged"), stratum=MARKS["stratum"])
    ask(handle, dict.fromkeys(ids[14:19], "gold"), answer="wrong", reason=MARKS["gold reason"], at=GOLD_STAMP)
    ask(handle, {ids[19]: "practice", ids[20]: "judged"}, reason="told", stratum=MARKS["stratum"])
    study.record_vote(handle, ids[0], MARKS["volunteer"], "wrong", comment=MARKS["comment"], presentation={"by": MARKS["presentation"]})
    return handle


def unpacked(path: Path) -> bytes:
    """All bytes of a file, its texts and numbers, and what its shapes hold, unpacked."""
    found = [path.read_bytes(), cells(path).encode()]
    with closing(sqlite3.connect(path)) as raw:
        for (blob,) in raw.execute("SELECT content FROM blob"):
            start = 0
            while (start := blob.find(b"PK\x03\x04", start)) >= 0:  # each array of the zip
                name, extra = (int.from_bytes(blob[start + k : start + k + 2], "little") for k in (26, 28))
                found += [blob[start : start + 30 + name], zlib.decompressobj(-15).decompress(blob[start + 30 + name + extra :])]
                start += 30
    return b"\n".join(found)


def test_nothing_that_a_volunteer_may_not_know_is_in_the_bytes_of_a_packet(tmp_path):
    with marked_study(tmp_path / "a.db") as whole:
        make_packet(whole, "anna", tmp_path / "p.db")
        make_packet(whole, "carl", tmp_path / "q.db")
    parent = unpacked(tmp_path / "a.db")
    for name in ("p.db", "q.db"):
        found = unpacked(tmp_path / name)
        assert b"vertices" in found
        for what, mark in MARKS.items():
            assert mark.encode() in parent, f"the test would not find {what}"
            assert mark.encode() not in found, what
        for mark in (GOLD_STAMP[:10].encode(), b"mk-", np.float64(MARKS["score"]).byteswap().tobytes()):
            assert mark in parent
            assert mark not in found
        assert len(content(tmp_path / name)["blob"]) == 2
    assert b"carl" not in unpacked(tmp_path / "p.db")


def looks(path: Path) -> dict[str, dict[str, object]]:
    """All that can be told of each item of a study file without looking at it: rows, cells, lengths, places in the file."""
    found: dict[str, dict[str, object]] = {}
    with closing(sqlite3.connect(path)) as raw:
        raw.row_factory = sqlite3.Row
        raw_bytes = path.read_bytes()
        for table, key in (("item", "id"), ("asked", "item_id")):
            for row in raw.execute(f"SELECT rowid AS place, * FROM {table} ORDER BY rowid"):
                told = found.setdefault(row[key], {})
                told |= {f"{table}.{name}": row[name] for name in row.keys() if name not in ("id", "item_id", "payload")}  # noqa: SIM118
                if table == "item":
                    payload = json.loads(row["payload"])
                    told |= {"length": len(row["payload"]), "keys": repr([(name, sorted(side)) for name, side in payload.items()])}
                told[f"{table}.byte"] = raw_bytes.find(row[key].encode())
    return found


def tells(values: list[tuple[object, bool]]) -> bool:
    """Whether values tell the marked items from others: by how they are spread, or by how they are ordered.

    Each value by itself is compared with what chance gives (four standard deviations), and so is the sum of ranks (the
    test of Mann and Whitney).
    """
    n, marked = len(values), sum(mark for _, mark in values)
    share = marked / n
    groups: dict[object, list[bool]] = {}
    for value, mark in values:
        groups.setdefault(value, []).append(mark)
    for marks in groups.values():
        spread = math.sqrt(len(marks) * share * (1 - share) * (n - len(marks)) / max(1, n - 1))
        if abs(sum(marks) - share * len(marks)) > 4 * spread + 1e-9:
            return True
    if len(groups) < 2 or None in groups:
        return False
    order = {value: k for k, value in enumerate(sorted(groups))}  # type: ignore[type-var]
    numbers = np.array([order[value] for value, _ in values])
    ranks = np.array([(numbers < value).sum() + ((numbers == value).sum() + 1) / 2 for value in numbers])
    total = ranks[[mark for _, mark in values]].sum()
    spread = math.sqrt(ranks.var() * marked * (n - marked) / (n - 1))
    return bool(abs(total - marked * ranks.mean()) > 4 * spread)


def test_gold_cannot_be_told_by_anything_in_a_packet(tmp_path):
    """300 matches, a third of them gold that was added later and comes from other files."""
    rng = np.random.default_rng(4)
    items: dict[str, Item] = {}
    while len(items) < 300:
        i, j = rng.choice(5, 2, replace=False).tolist()
        one, other = (tuple(rng.choice(PARTS, 2, replace=False).tolist()) for _ in range(2))
        files = ("a.off", "b.off") if len(items) < 200 else ("/checks/known/a.off", "/checks/known/b.off")
        item = match(strip(i), one, strip(j), other, files)
        items.setdefault(item.id, item)
    gold = list(items)[200:]
    with study.create_study(tmp_path / "a.db", name="Many", seed="s", votes=2) as handle:
        keep_shapes(handle, [strip(seed) for seed in range(5)])
        for role, ids, at in (("judged", list(items)[:200], "2026-05-01"), ("gold", gold, "2026-07-01")):
            study.add_items(handle, [items[found] for found in ids])
            ask(handle, dict.fromkeys(ids, role), reason=role, stratum=role, at=at)
        make_packet(handle, "anna", tmp_path / "p.db")
    for path, expected in ((tmp_path / "a.db", True), (tmp_path / "p.db", False)):
        found = looks(path)
        names = sorted({name for told in found.values() for name in told})
        telling = [name for name in names if tells([(told.get(name), item in gold) for item, told in found.items()])]
        assert bool(telling) == expected, telling
        if expected:
            assert {"asked.role", "asked.place", "item.place", "item.created_at", "length"} <= set(telling)
        else:
            assert len(found) == 300
