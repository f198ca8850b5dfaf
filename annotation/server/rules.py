"""What a study's tables are guarded by on PostgreSQL: triggers, row-level security, and what a volunteer sees.

The tables and views of `annotation.storage.schema` lie in the schema `concord`. An invited volunteer's connection looks first
into the schema `blind`, whose views bear the names of tables and views and hide what a volunteer may not know, so that
`annotation.voting.answering` works through it unchanged. Behind these views row-level security is on for every table, so that a
grant made by mistake still shows nothing but own rows.

Who is connected is told by `session_user`, which SET ROLE does not change, looked up in the table `invited`.
"""

from collections.abc import Iterator

from ..storage import schema

SCHEMA, BLIND = "concord", "blind"
RESEARCHER_PATH, VOLUNTEER_PATH = f"{SCHEMA}, pg_temp", f"{BLIND}, {SCHEMA}, pg_temp"

OWN_TABLES = (
    "CREATE TABLE concord.version (number integer NOT NULL)",
    "CREATE UNIQUE INDEX one_version ON concord.version ((true))",
    """CREATE TABLE concord.invited (role text PRIMARY KEY, researcher boolean NOT NULL,
    code text UNIQUE REFERENCES concord.volunteer (code) ON UPDATE CASCADE ON DELETE CASCADE,
    CHECK (researcher = (code IS NULL)))""",
)
"""The number of the version of the schema, and whose connection is whose (no volunteer may read it)."""

_DEFINER = "STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp"
# What an item shows and nothing else, as `annotation.exchange.packets.blinded` has it: files may be named after methods. A NUL in
# a name is no JSON that PostgreSQL can take to pieces.
SHOWN = r"""CREATE OR REPLACE FUNCTION concord.shown(kind text, payload text) RETURNS text LANGUAGE sql IMMUTABLE AS $$
WITH given AS MATERIALIZED (SELECT replace(payload, '\u0000', '\ufffd')::jsonb AS p)
SELECT CASE WHEN kind = 'shape' THEN
(SELECT jsonb_object_agg(side, jsonb_strip_nulls(jsonb_build_object('file', '', 'sha256', p -> side -> 'sha256',
'segments', p -> side -> 'segments', 'segmentation', p -> side -> 'segmentation')))
FROM unnest(ARRAY['source', 'target']) AS side)
ELSE jsonb_strip_nulls(jsonb_build_object('size', p -> 'size', 'pieces',
(SELECT jsonb_agg(jsonb_build_object('piece', piece -> 'piece', 'x', piece -> 'x', 'y', piece -> 'y', 'png', piece -> 'png')
ORDER BY place) FROM jsonb_array_elements(p -> 'pieces') WITH ORDINALITY AS t (piece, place))))
END::text FROM given $$"""
FUNCTIONS = (
    f"""CREATE OR REPLACE FUNCTION concord.own_code() RETURNS text LANGUAGE sql {_DEFINER}
    AS 'SELECT code FROM concord.invited WHERE role = session_user'""",
    f"""CREATE OR REPLACE FUNCTION concord.is_researcher() RETURNS boolean LANGUAGE sql {_DEFINER}
    AS 'SELECT EXISTS (SELECT 1 FROM concord.invited WHERE role = session_user AND researcher)'""",
    f"""CREATE OR REPLACE FUNCTION concord.follows_own(earlier text, item text, during integer) RETURNS boolean LANGUAGE sql {_DEFINER}
    AS 'SELECT earlier IS NULL OR EXISTS (SELECT 1 FROM concord.event AS e WHERE e.uuid = earlier AND e.item_id = item
    AND e.round = during AND e.volunteer = concord.own_code())'""",
    SHOWN,
    """CREATE OR REPLACE FUNCTION concord.refuse_change() RETURNS trigger LANGUAGE plpgsql AS
    $$ BEGIN RAISE EXCEPTION 'votes are only ever added: nothing may change or remove one'
    USING ERRCODE = 'restrict_violation'; END $$""",
)
NEVER_CHANGED = "event_never_changed"
TRIGGERS = (
    f"""CREATE TRIGGER {NEVER_CHANGED} BEFORE UPDATE OR DELETE OR TRUNCATE ON concord.event
    FOR EACH STATEMENT EXECUTE FUNCTION concord.refuse_change()""",
    f"ALTER TABLE concord.event ENABLE ALWAYS TRIGGER {NEVER_CHANGED}",
)

_MINE = "volunteer = (SELECT concord.own_code())"
POLICIES = (
    "CREATE POLICY anybody ON concord.version FOR SELECT USING (true)",
    f"CREATE POLICY own_rows ON concord.event FOR SELECT USING ({_MINE})",
    f"""CREATE POLICY own_votes ON concord.event FOR INSERT
    WITH CHECK ({_MINE} AND concord.follows_own(supersedes, item_id, round))""",
    "CREATE POLICY own_row ON concord.volunteer FOR SELECT USING (code = (SELECT concord.own_code()))",
    "CREATE POLICY shapes ON concord.blob FOR SELECT USING ((SELECT concord.own_code()) IS NOT NULL)",
)

# Views are read with the rights of the study's owner, who passes row-level security; hence each says whose rows. Items
# come by their ids, since the order in which a run proposed them is that of its scores, and without the time that tells
# runs apart.
_INVITED = "WHERE (SELECT concord.own_code()) IS NOT NULL"  # a login may outlive its invitation for a moment
_OWN = "WHERE volunteer = concord.own_code()"
BLIND_VIEWS = {
    "study": f"""SELECT id, name, question, guideline, ''::text AS seed, '{{}}'::text AS settings, app_version, created_at,
    votes, adaptive, unsure FROM concord.study {_INVITED}""",
    "item": f"""SELECT id, kind, concord.shown(kind, payload) AS payload, ''::text AS created_at FROM concord.item
    {_INVITED} ORDER BY id""",
    "practice": f"SELECT item_id, answer, reason FROM concord.practice {_INVITED} ORDER BY item_id",
    "open_item": f"SELECT volunteer, item_id, round FROM concord.open_item {_OWN} ORDER BY item_id",
    "standing_vote": f"SELECT * FROM concord.standing_vote {_OWN}",
    "current_vote": f"SELECT * FROM concord.current_vote {_OWN}",
}


def guards() -> Iterator[str]:
    """The statements that guard the tables and views of a new study, in order."""
    yield from (*OWN_TABLES, *FUNCTIONS, *TRIGGERS)
    yield from row_level_security()
    yield from POLICIES
    yield "REVOKE ALL ON SCHEMA concord FROM PUBLIC"
    yield from private()
    yield from blind_views()


def guards_again() -> Iterator[str]:
    """Those that are due after a migration, for new tables and for rules that have changed."""
    yield from FUNCTIONS
    yield from row_level_security()
    yield from private()
    yield from blind_views()


def row_level_security() -> Iterator[str]:
    """No row of any table for anybody but its owner and researchers, unless a policy says so."""
    for name in (*schema.metadata.tables, "version", "invited"):
        yield f"ALTER TABLE concord.{name} ENABLE ROW LEVEL SECURITY"
        yield f"DROP POLICY IF EXISTS researchers ON concord.{name}"
        if name != "invited":
            yield f"CREATE POLICY researchers ON concord.{name} USING ((SELECT concord.is_researcher()))"


def private() -> Iterator[str]:
    """Nothing is granted to everybody."""
    yield "REVOKE ALL ON ALL TABLES IN SCHEMA concord FROM PUBLIC"
    yield "REVOKE ALL ON ALL FUNCTIONS IN SCHEMA concord FROM PUBLIC"


def blind_views() -> Iterator[str]:
    """The statements that make the schema of volunteers (anew after a migration, which makes all views anew)."""
    yield f"CREATE SCHEMA {BLIND}"
    for name, query in BLIND_VIEWS.items():
        yield f"CREATE VIEW {BLIND}.{name} WITH (security_barrier) AS {query}"


def volunteer_grants(group: str) -> Iterator[str]:
    """What a volunteer's group may do: read the blind views and own rows, and add votes."""
    yield f"GRANT USAGE ON SCHEMA concord, {BLIND} TO {group}"
    yield f"GRANT SELECT ON ALL TABLES IN SCHEMA {BLIND} TO {group}"
    yield f"GRANT SELECT ON concord.volunteer, concord.blob, concord.version TO {group}"
    yield f"GRANT SELECT, INSERT ON concord.event TO {group}"
    yield from _callable(group)


def researcher_grants(group: str) -> Iterator[str]:
    """What a further researcher may do: everything but change votes and invite."""
    yield f"GRANT USAGE ON SCHEMA concord TO {group}"
    yield f"GRANT SELECT ON ALL TABLES IN SCHEMA concord TO {group}"
    for name in schema.metadata.tables:
        allowed = "INSERT" if name == "event" else "INSERT, UPDATE, DELETE"
        yield f"GRANT {allowed} ON concord.{name} TO {group}"
    yield f"REVOKE ALL ON concord.invited FROM {group}"
    yield from _callable(group)


def _callable(group: str) -> Iterator[str]:
    """What the policies call, they call with the rights of whoever asks."""
    for function in ("own_code()", "is_researcher()", "follows_own(text, text, integer)", "shown(text, text)"):
        yield f"GRANT EXECUTE ON FUNCTION concord.{function} TO {group}"
