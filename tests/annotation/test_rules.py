"""The rules that views hold (which votes count, who is still asked what), against the same rules in plain Python."""

import random
from collections import Counter
from typing import NamedTuple

import pytest
from sqlalchemy import create_engine, insert, select

from annotation.storage import schema

ITEMS, CODES = tuple(f"item-{n}" for n in range(6)), ("anna", "bert", "carl", "dora")


class World(NamedTuple):
    """Rows of a small study."""

    k: int
    adaptive: bool
    adjudicators: set[str]
    asked: dict[str, tuple[str, bool]]  # role, overlapped
    held: set[tuple[str, str]]  # item, volunteer
    events: list[dict[str, object]]


def random_world(seed: int) -> World:
    """Any rows, also such as only merges of copies make: equal clocks, several votes that stand."""
    draw = random.Random(seed)
    roles = ["judged"] * 4 + ["gold", "practice"]
    asked = {one: (draw.choice(roles), draw.random() < 0.3) for one in ITEMS if draw.random() < 0.8}
    held = {(one, code) for one in ITEMS for code in CODES[:2] if draw.random() < 0.5}
    events: list[dict[str, object]] = []
    for _ in range(draw.randrange(60)):
        votes = [row for row in events if row["kind"] == "vote"]
        taken = draw.choice(votes) if votes and draw.random() < 0.25 else None
        where = {"item_id": draw.choice(ITEMS), "volunteer": draw.choice(CODES), "round": int(draw.random() < 0.8)}
        if taken is not None:
            where = {name: taken[name] for name in where}
        events.append(
            {"uuid": f"{draw.getrandbits(32):08x}", "kind": "vote" if taken is None else "retraction", **where,
             "answer": draw.choice(("correct", "correct", "wrong", "unsure")) if taken is None else None, "comment": "",
             "supersedes": taken and taken["uuid"], "clock": draw.randrange(5), "presentation": "{}", "app_version": "",
             "created_at": f"2026-01-0{draw.randrange(1, 4)}"}
        )  # fmt: skip
    return World(draw.choice((0, 1, 2, 2, 3, 4)), draw.random() < 0.5, {code for code in CODES if draw.random() < 0.3},
                 asked if draw.random() < 0.7 else {}, held if draw.random() < 0.5 else set(), events)  # fmt: skip


def current(world: World) -> dict[tuple[str, str, int], dict[str, object]]:
    """Of the votes on one item of one volunteer that nobody retracted, the newest by count, then by time, then by id."""
    gone = {row["supersedes"] for row in world.events if row["kind"] == "retraction"}
    found: dict[tuple[str, str, int], dict[str, object]] = {}
    for row in sorted(world.events, key=lambda row: (row["clock"], row["created_at"], row["uuid"])):
        if row["kind"] == "vote" and row["uuid"] not in gone:
            found[row["item_id"], row["volunteer"], row["round"]] = row
    return found


def open_to(world: World, code: str) -> set[tuple[str, int]]:
    """What a volunteer is still asked about, and in which round."""
    votes = current(world)
    packet = {item for item, holder in world.held if holder == code}
    found = set()
    for item in world.asked or ITEMS:
        role, overlapped = world.asked.get(item, ("judged", False))
        said = Counter(row["answer"] for (one, _, during), row in votes.items() if (one, during) == (item, 1))
        total, right, wrong = said.total(), said["correct"], said["wrong"]
        touched = {row["volunteer"] for row in world.events if (row["item_id"], row["round"]) == (item, 1)}
        packets = len({holder for one, holder in world.held if one == item} - touched)
        settled_early = world.adaptive and not overlapped and max(right, wrong) + packets > world.k / 2
        tied = right == wrong and packets == 0
        wants_more = (total + packets < world.k and not settled_early) or (total == world.k and tied)
        if role == "practice":
            asks = code not in world.adjudicators
        elif packet:
            asks = item in packet
        elif code in world.adjudicators:
            asks = tied and total >= max(world.k, 2)
        else:
            asks = world.k == 0 or role == "gold" or wants_more
        during = 0 if role == "practice" else 1
        if asks and (item, code, during) not in votes:
            found.add((item, during))
    return found


def written(world: World, connection) -> None:
    connection.execute(insert(schema.study).values(
        id="s", name="", question="", guideline="", seed="", settings="{}", app_version="", created_at="",
        votes=world.k, adaptive=int(world.adaptive)))  # fmt: skip
    for item in ITEMS:
        connection.execute(insert(schema.item).values(id=item, kind="puzzle", payload="{}", created_at=""))
    for code in CODES:
        adjudicates = int(code in world.adjudicators)
        connection.execute(insert(schema.volunteer).values(code=code, seed="", created_at="", adjudicates=adjudicates))
    for item, (role, overlapped) in world.asked.items():
        connection.execute(insert(schema.asked).values(
            item_id=item, role=role, reason="", stratum="", overlapped=int(overlapped), added_at=""))  # fmt: skip
    for item, code in world.held:
        connection.execute(insert(schema.assignment).values(item_id=item, volunteer=code, made_at=""))
    for row in world.events:
        connection.execute(insert(schema.event).values(row))


def checked(world: World, connection, seed: int) -> int:
    """Hold the views of one world to the rules; how often something was asked of somebody."""
    view, asked_of_somebody = schema.open_item.c, 0
    counted = set(connection.scalars(select(schema.current_vote.c.uuid)))
    assert counted == {row["uuid"] for row in current(world).values()}, seed
    for code in CODES:
        rows = connection.execute(select(view.item_id, view.round).where(view.volunteer == code)).all()
        assert len(rows) == len(set(rows))
        assert set(map(tuple, rows)) == open_to(world, code), (seed, code)
        asked_of_somebody += len(rows)
    for item in ITEMS:  # one at a time as all together
        rows = connection.execute(select(view.volunteer, view.round).where(view.item_id == item)).all()
        assert set(map(tuple, rows)) == {(code, r) for code in CODES for one, r in open_to(world, code) if one == item}
    return asked_of_somebody


@pytest.mark.parametrize("block", range(6))
def test_views_say_what_the_plain_rules_say(block):
    asked_of_somebody = 0
    for seed in range(40 * block, 40 * block + 40):
        world = random_world(seed)
        with create_engine("sqlite://").begin() as connection:
            schema.create_schema(connection)
            written(world, connection)
            asked_of_somebody += checked(world, connection, seed)
    assert asked_of_somebody > 100


def test_views_say_the_same_on_a_server(database):
    asked_of_somebody = 0
    engine = create_engine(database.replace("postgresql:", "postgresql+psycopg:"))
    with engine.begin() as connection:
        connection.exec_driver_sql("SET jit = off")
        schema.create_schema(connection)
        for seed in range(25):
            with connection.begin_nested() as one:
                written(random_world(seed), connection)
                asked_of_somebody += checked(random_world(seed), connection, seed)
                one.rollback()
    engine.dispose()
    assert asked_of_somebody > 60
