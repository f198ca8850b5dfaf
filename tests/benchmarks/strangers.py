"""Damaged files: whatever they hold, loading them gives a valid shape or one sentence.

    python tests/benchmarks/strangers.py [--files 2000] [--seed 0] [--keep FOLDER]

Small valid files of every kind are damaged at random (bits, lines, counts, numbers, headers, encodings, the plan of a
GLB file) and loaded in a child process that may use 3 GiB of address space and 10 s a file. Counted are valid shapes,
sentences (`BadInput`), and everything that must not happen: another exception, a sentence that is none, a death, a
hang, more than 2 GB, an invalid shape. Exits with 1 if any of these happened; `--keep` stores those files.
"""

import argparse
import gzip
import io
import itertools
import json
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from collections import Counter
from pathlib import Path
from random import Random

ALLOWED = ("valid", "sentence")
SECONDS, ADDRESS_SPACE, MOST_MEMORY, LONGEST = 10, 3 * 2**30, 2 * 10**9, 250
ABSURD = ("-1", "0", "1", "2", "7", "255", "65536", "2147483648", "4294967295", "1000000000000", "9223372036854775808",
          "1" * 400, "nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1.5", "1_0", "0x10", "x", "", "\u0663", "-9999999999")  # fmt: skip
Files = dict[str, bytes]  # suffix -> content; all files of one stem

# --- valid files ---------------------------------------------------------------------------------------------------

GRID = [(x / 3, y / 3, (x * y % 3) / 9) for y in range(5) for x in range(5)]
QUADS = [(y * 5 + x, y * 5 + x + 1, y * 5 + x + 6, y * 5 + x + 5) for y in range(4) for x in range(4)]
TRIANGLES = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
MIXED = [*QUADS[:8], *TRIANGLES[16:], (0, 1, 2, 7, 6, 5)]


def rows(table) -> str:
    return "".join(" ".join(f"{v:.6g}" for v in row) + "\n" for row in table)


def off(faces) -> bytes:
    return f"OFF\n{len(GRID)} {len(faces)} 0\n{rows(GRID)}{rows((len(f), *f) for f in faces)}".encode()


def obj(faces, mark: str = "g") -> bytes:
    points = "".join(f"v {x:.6g} {y:.6g} {z:.6g}\n" for x, y, z in GRID)
    lines = [f"{mark} part{n % 3}\n" * (n % 4 == 0) + "f " + " ".join(str(i + 1) for i in f) + "\n" for n, f in enumerate(faces)]
    return f"# a grid\nmtllib none.mtl\n{points}vt 0 0\nvn 0 0 1\nusemtl red\n{''.join(lines)}".encode()


def obj_backward() -> bytes:
    blocks = ("v {} {} {}\nv {} {} {}\nv {} {} {}\nf -3//1 -2//1 -1//1\n".format(*GRID[a], *GRID[b], *GRID[c])
              for a, b, c in TRIANGLES)  # fmt: skip
    return ("vn 0 0 1\n" + "".join(blocks)).encode()


def ply(faces, kind: str = "ascii") -> bytes:
    import numpy as np

    head = (f"ply\nformat {kind} 1.0\ncomment a grid\nelement vertex {len(GRID)}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nproperty int segment\n"
            "end_header\n").encode()  # fmt: skip
    if kind == "ascii":
        return head + (rows(GRID) + rows((len(f), *f, n % 4) for n, f in enumerate(faces))).encode()
    order = "<" if "little" in kind else ">"
    body = [np.array(GRID, dtype=order + "f4").tobytes()]
    for n, f in enumerate(faces):
        body += [bytes([len(f)]), np.array([*f, n % 4], dtype=order + "i4").tobytes()]
    return head + b"".join(body)


def stl_text() -> bytes:
    facets = ("facet normal 0 0 1\nouter loop\n" + "".join("vertex {} {} {}\n".format(*GRID[i]) for i in t) + "endloop\nendfacet\n"
              for t in TRIANGLES)  # fmt: skip
    half = list(facets)
    return f"solid one\n{''.join(half[:16])}endsolid one\nsolid two\n{''.join(half[16:])}endsolid two\n".encode()


def stl_binary() -> bytes:
    import numpy as np

    facets = (np.array([(0, 0, 1), *(GRID[i] for i in t)], dtype="<f4").tobytes() + b"\0\0" for t in TRIANGLES)
    return b"binary".ljust(80, b"\0") + len(TRIANGLES).to_bytes(4, "little") + b"".join(facets)


def glb_bytes(plan, binary: bytes) -> bytes:
    text = json.dumps(plan).encode()
    text += b" " * (-len(text) % 4)
    chunks = len(text).to_bytes(4, "little") + b"JSON" + text + len(binary).to_bytes(4, "little") + b"BIN\0" + binary
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(chunks)).to_bytes(4, "little") + chunks


def glb_halves(data: bytes):
    length = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def glb() -> bytes:
    import trimesh

    scene = trimesh.Scene()
    for n in range(3):
        grid = trimesh.Trimesh(GRID, TRIANGLES, process=False)
        scene.add_geometry(grid, node_name=f"part{n}", transform=trimesh.transformations.translation_matrix((n, 0, 0)))
    return scene.export(file_type="glb")


def labels(count: int) -> bytes:
    return "".join(f"{n % 5}\n" for n in range(count)).encode()


def valid_files() -> list[tuple[str, Files]]:
    """Suffix to damage, and the files of one stem."""
    return [
        (".off", {".off": off(TRIANGLES)}),
        (".off", {".off": off(MIXED), ".seg": labels(len(MIXED))}),
        (".seg", {".off": off(QUADS), ".seg": labels(len(QUADS))}),
        (".obj", {".obj": obj(TRIANGLES)}),
        (".obj", {".obj": obj(MIXED, mark="o"), ".seg": labels(len(MIXED))}),
        (".obj", {".obj": obj_backward()}),
        (".ply", {".ply": ply(TRIANGLES)}),
        (".ply", {".ply": ply(MIXED)}),
        (".ply", {".ply": ply(TRIANGLES, "binary_little_endian")}),
        (".ply", {".ply": ply(MIXED, "binary_big_endian")}),
        (".stl", {".stl": stl_text()}),
        (".stl", {".stl": stl_binary()}),
        (".glb", {".glb": glb()}),
        (".glb", {".glb": glb(), ".seg": labels(3 * len(TRIANGLES))}),
    ]


# --- damage --------------------------------------------------------------------------------------------------------


def flip_bits(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(random.choice((1, 3, 30))):
        changed[random.randrange(len(changed))] ^= 1 << random.randrange(8)
    return bytes(changed)


def flip_head(data: bytes, random: Random) -> bytes:
    return flip_bits(data[:200], random) + data[200:]


def cut(data: bytes, random: Random) -> bytes:
    return data[: random.randrange(len(data))]


def cut_out(data: bytes, random: Random) -> bytes:
    start = random.randrange(len(data))
    return data[:start] + data[start + random.choice((1, 4, 50)) :]


def insert(data: bytes, random: Random) -> bytes:
    at = random.randrange(len(data))
    piece = random.choice((random.randbytes(9), b"\xff\xfe\x80\xc3", b"\0" * 50, b"\n" * 99, b"1" * 300_000, b" 1" * 100_000,
                           b"#", b"\n# x\n", b"#" * 9999, b"\r", b"\\\n", b"\x0c", "é٣".encode()))  # fmt: skip
    return data[:at] + piece + data[at:]


def lines(data: bytes, random: Random) -> bytes:
    table = data.split(b"\n")
    at, other = random.randrange(len(table)), random.randrange(len(table))
    match random.randrange(5):
        case 0:
            table.insert(at, table[other])
        case 1:
            del table[at]
        case 2:
            table[at], table[other] = table[other], table[at]
        case 3:
            table[at : at + 1] = [table[at]] * 5000
        case _:
            table[at] = b""
    return b"\n".join(table)


def words(data: bytes, random: Random) -> bytes:
    """One word becomes an absurd one; the first lines, where counts are, more often than others."""
    table = data.split(b"\n")
    at = random.randrange(min(len(table), random.choice((2, 12, len(table)))))
    row = table[at].split(b" ")
    row[random.randrange(len(row))] = random.choice(ABSURD).encode()
    table[at] = b" ".join(row)
    return b"\n".join(table)


def wrap(data: bytes, random: Random) -> bytes:
    match random.randrange(8):
        case 0:
            return gzip.compress(data)
        case 1:
            with io.BytesIO() as stream:
                with zipfile.ZipFile(stream, "w") as archive:
                    archive.writestr("a.off", data)
                return stream.getvalue()
        case 2:
            return data.decode("latin-1").encode("utf-16")
        case 3:
            return b"\xef\xbb\xbf" + data
        case 4:
            return data.replace(b"\n", b"\r\n")
        case 5:
            return data.replace(b"\n", b" ")
        case 6:
            return data + data
        case _:
            return random.randbytes(random.choice((1, 20, 84, 5000)))


def counts(data: bytes, random: Random) -> bytes:
    """A binary number of four bytes becomes absurd: the triangles of an STL file, the lengths of a GLB file."""
    at = random.choice((80, 8, 12, 4, random.randrange(len(data))))
    return data[:at] + random.choice((0, 1, 2**16, 2**31 - 1, 2**32 - 1, 10**7)).to_bytes(4, "little") + data[at + 4 :]


def plan(data: bytes, random: Random) -> bytes:
    """The plan of a GLB file, damaged as a table rather than as text."""
    try:
        tree, binary = glb_halves(data)
        for _ in range(random.choice((1, 1, 3))):
            random.choice((plan_value, plan_value, plan_key, plan_nodes, plan_buffers))(tree, random)
        return glb_bytes(tree, binary)
    except (ValueError, KeyError, IndexError, TypeError, AttributeError):
        return flip_head(data, random)


def plan_value(tree, random: Random) -> None:
    """One number or text of the plan becomes absurd."""
    leaves = list(_leaves(tree))
    owner, key = random.choice(leaves)
    owner[key] = random.choice((-1, 0, 1, 2, 7, 2**31, 2**32, 2**63, 10**12, 10**400, 1.5, float("nan"), 1e308, None, True, "x", [], {},
                                "VEC3", "MAT4", "SCALAR", 5120, 5123, 5126, [[]] * 9, "../../secret", "a" * 100_000))  # fmt: skip


def _leaves(tree):
    for key, value in list(tree.items() if isinstance(tree, dict) else enumerate(tree)):
        if isinstance(value, dict | list) and value:
            yield from _leaves(value)
        else:
            yield tree, key


def plan_key(tree, random: Random) -> None:
    owner = random.choice([tree, *(item for value in tree.values() if isinstance(value, list) for item in value)])
    key = random.choice(list(owner))
    if random.random() < 0.5:
        del owner[key]
    else:
        owner[random.choice(("sparse", "extensions", "byteStride", "byteOffset", "normalized", "uri", "skin", "children"))] = owner[key]


def plan_nodes(tree, random: Random) -> None:
    """Nodes in a circle, with two parents, by the thousand, in a long chain, or beside themselves."""
    nodes = tree["nodes"]
    match random.randrange(6):
        case 0:
            random.choice(nodes)["children"] = list(range(len(nodes)))
        case 1:
            nodes[-1]["children"] = [0]
        case 2:
            nodes += [{"mesh": 0}] * random.choice((100, 30_000, 200_000))
            tree["scenes"][0]["nodes"] = list(range(len(nodes)))
        case 3:
            start = len(nodes)
            nodes += [{"mesh": 0, "children": [start + n + 1]} for n in range(random.choice((50, 5000)))] + [{"mesh": 0}]
            tree["scenes"][0]["nodes"] = [start]
        case 4:
            nodes[0]["matrix"] = [random.choice((0, 1, -1, 1e308, float("nan"))) for _ in range(16)]
        case _:
            nodes[-1] |= {"rotation": [0, 0, 0, 0], "scale": [0, 1e308, -1], "translation": [float("inf"), 0, 0]}


def plan_buffers(tree, random: Random) -> None:
    """Other files, the network, absurd lengths, thousands of views and of parts of the same bytes."""
    match random.randrange(6):
        case 0:
            elsewhere = ("/etc/passwd", "http://localhost:9/x", "data:;base64,AAAA", "data:base64,", "../a.off")
            tree["buffers"][0]["uri"] = random.choice(elsewhere)
        case 1:
            tree["buffers"][0]["byteLength"] = tree["bufferViews"][0]["byteLength"] = 2**40
        case 2:
            tree["accessors"][0] |= {"count": random.choice((10**9, 10**13)), "byteOffset": random.choice((0, -8, 2**40))}
            if random.random() < 0.5:
                tree["accessors"][0].pop("bufferView")
        case 3:
            tree["bufferViews"] += [dict(tree["bufferViews"][0]) for _ in range(5000)]
        case 4:
            tree["meshes"][0]["primitives"] *= 20_000
        case _:
            tree["bufferViews"][0]["byteStride"] = random.choice((0, 1, 4, 12, -4, 2**31))


TEXT = (flip_bits, cut, cut_out, insert, lines, lines, words, words, words, wrap)
BINARY = (flip_bits, flip_head, flip_head, cut, cut_out, insert, counts, counts, wrap)


def damaged(random: Random, valid: list[tuple[str, Files]]) -> tuple[str, Files]:
    """Suffix of the mesh and the files of one stem, one of them damaged once or a few times."""
    suffix, files = random.choice(valid)
    files = dict(files)
    data = files[suffix]
    if suffix == ".glb":
        changes = (plan, plan, plan, *BINARY)
    else:
        changes = BINARY if b"\0" in data else TEXT
        changes = (*changes, words) if suffix == ".ply" else changes
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        data = random.choice(changes)(data, random) if data else data
    files[suffix] = data
    mesh = next(iter(files))
    if random.random() < 0.04:
        wrong = random.choice((".off", ".obj", ".ply", ".stl", ".glb", ".txt", ".PLY"))
        files = {wrong if s == mesh else s: content for s, content in files.items()}
        mesh = wrong
    return mesh, files


# --- the child -----------------------------------------------------------------------------------------------------


def verdict(path: Path) -> tuple[str, str]:
    """What loading a file comes to: a kind of outcome and its words."""
    from engine.errors import BadInput
    from engine.shapes.meshfile import load_shape

    try:
        shape = load_shape(path)
    except BadInput as error:
        text = str(error)
        fine = text.isprintable() and len(text.replace(str(path.parent), "")) <= LONGEST and path.stem in text
        return ("over memory" if "more memory" in text else "sentence" if fine else "no sentence"), text
    except BaseException as error:
        return "other exception", f"{type(error).__name__}: {error}"
    return ("invalid", wrong) if (wrong := fault(shape)) else ("valid", f"{len(shape.mesh.faces)} triangles")


def fault(shape) -> str:
    """What is wrong with a shape that was accepted, or ''."""
    import numpy as np

    vertices, faces, found = shape.mesh.vertices, shape.mesh.faces, shape.segmentation.labels
    if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces) or faces.min() < 0 or faces.max() >= len(vertices):
        return "an index is out of range"
    if not np.isfinite(vertices[faces]).all():
        return "a coordinate is not finite"
    names = shape.segmentation.names
    if len(found) != len(faces) or sorted(set(found.tolist())) != list(range(len(names))) or len(set(names)) != len(names):
        return "labels do not match"
    return ""


def child(seed: int, start: int, stop: int, folder: Path) -> None:
    """Load files `start` to `stop`, one JSON line before and one after each."""
    import resource

    import engine.shapes.meshfile  # noqa: F401 - what it needs is loaded before the limits hold

    valid = valid_files()
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    for index in range(start, stop):
        stem = f"s{seed}n{index}"
        suffix, files = damaged(Random(f"{seed}/{index}"), valid)
        for ending, content in files.items():
            (folder / (stem + ending)).write_bytes(content)
        print(json.dumps({"index": index, "state": "loading"}), flush=True)
        signal.alarm(SECONDS)
        begin = time.perf_counter()
        kind, words = verdict(folder / (stem + suffix))
        taken = time.perf_counter() - begin
        signal.alarm(0)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
        kind = "over memory" if peak > MOST_MEMORY else kind
        print(json.dumps({"index": index, "state": kind, "words": words, "suffix": suffix, "seconds": taken, "peak": peak}), flush=True)
        if kind in ALLOWED:
            for ending in files:
                (folder / (stem + ending)).unlink()


# --- the parent ----------------------------------------------------------------------------------------------------


def run(files: int, seed: int, folder: Path) -> list[dict]:
    """One record a file; a child that dies is replaced by one that goes on after the file that killed it."""
    records: list[dict] = []
    while len(records) < files:
        command = [sys.executable, __file__, "--child", str(seed), str(len(records)), str(files), str(folder)]
        child_process = subprocess.run(command, capture_output=True, text=True, check=False, cwd=Path(__file__).resolve().parents[2])
        told = [json.loads(line) for line in child_process.stdout.splitlines()]
        ended = [record for record in told if record["state"] != "loading"]
        records += ended
        if len(told) == 2 * len(ended) and child_process.returncode == 0:
            continue
        if len(told) == 2 * len(ended):
            raise RuntimeError(f"The child failed between two files: {child_process.stderr[-2000:]}")
        state = "hang" if child_process.returncode == -signal.SIGALRM else "killed"
        records.append({"index": len(records), "state": state, "words": f"code {child_process.returncode}", "suffix": "?",
                        "seconds": SECONDS, "peak": 0})  # fmt: skip
    return records


def summary(records: list[dict]) -> str:
    """Outcomes by kind of file, and the slowest and the largest load."""
    tally = Counter((r["suffix"].lower(), r["state"]) for r in records)
    states = [*ALLOWED, *sorted({r["state"] for r in records} - set(ALLOWED))]
    kinds = sorted({suffix for suffix, _ in tally})
    table = [["", *states], *([kind, *(str(tally[kind, state]) for state in states)] for kind in kinds),
             ["all", *(str(sum(tally[kind, state] for kind in kinds)) for state in states)]]  # fmt: skip
    worst, largest = max(r["seconds"] for r in records), max(r["peak"] for r in records)
    lines = ["  ".join(f"{cell:>{max(6, len(state))}}" for cell, state in zip(row, table[0], strict=True)) for row in table]
    return "\n".join([*lines, f"slowest {worst:.2f} s, largest {largest / 1e6:.0f} MB"])


def main() -> int:
    """Damage, load, count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for the files that were not handled well")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        records = run(options.files, options.seed, folder)
    print(f"{options.files} damaged files, seed {options.seed}\n{summary(records)}")
    wrong = [record for record in records if record["state"] not in ALLOWED]
    for record in itertools.islice(wrong, 20):
        print(f"  file {record['index']} ({record['suffix']}): {record['state']}: {record['words'][:300]}")
    return 1 if wrong else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        child(*map(int, sys.argv[2:5]), Path(sys.argv[5]))
    else:
        sys.exit(main())
