"""Damaged pictures and folders of pieces: whatever they hold, reading them gives pixels or one sentence.

    python tests/benchmarks/strange_pictures.py [--files 2000] [--seed 0] [--keep FOLDER]

Small valid images of every format and mode are damaged at random (bits, blocks, numbers, length, two files spliced) and
read in a child process that may use 4 GiB of address space and 10 s a file; every fourth as one of three pieces in a
folder. Counted are pixels, sentences (`BadInput`), and everything that must not happen: another exception, a sentence that
is none, words on the standard error, a death, a hang, an impossible array. Exits with 1 if any of these happened.
"""

import argparse
import io
import json
import shutil
import signal
import subprocess
import sys
import tempfile
import zlib
from collections import Counter
from pathlib import Path
from random import Random

ALLOWED = ("pixels", "sentence")
SECONDS, ADDRESS_SPACE, LONGEST = 10, 4 * 2**30, 400


def valid_images() -> list[tuple[str, bytes]]:
    """Suffix and content of one small image of each format and mode."""
    import numpy as np
    from PIL import Image

    rng = np.random.default_rng(0)
    rgb = Image.fromarray(rng.integers(0, 256, (24, 31, 3), dtype=np.uint8)).resize((62, 48))
    deep = Image.fromarray(rng.integers(0, 65536, (24, 31)).astype(np.uint16))
    exif = Image.Exif()
    exif[0x0112] = 6
    clear = rgb.copy()
    clear.putalpha(Image.fromarray(np.tri(48, 62, dtype=np.uint8) * 255))
    made: list[tuple[str, bytes]] = []

    def add(suffix: str, image: Image.Image, kind: str, **how: object) -> None:
        buffer = io.BytesIO()
        image.save(buffer, kind, **how)
        made.append((suffix, buffer.getvalue()))

    for image in (rgb, clear, deep, rgb.convert("L"), rgb.convert("P"), rgb.convert("1"), clear.convert("LA")):
        add(".png", image, "PNG")
    add(".png", rgb, "PNG", exif=exif, transparency=(1, 2, 3))
    for image, how in ((rgb, {"exif": exif}), (rgb.convert("L"), {"progressive": True}), (rgb.convert("CMYK"), {})):
        add(".jpg", image, "JPEG", **how)
    for image in (rgb, deep, Image.fromarray(rng.random((20, 20), dtype=np.float32)), rgb.convert("CMYK"), rgb.convert("LAB")):
        add(".tif", image, "TIFF")
    for compression in ("tiff_lzw", "tiff_deflate", "jpeg", "packbits"):
        add(".tif", rgb, "TIFF", compression=compression, exif=exif)
    add(".tif", rgb.convert("1"), "TIFF", compression="group4")
    add(".gif", rgb, "GIF", save_all=True, append_images=[clear.convert("RGB")])
    for suffix, kind, how in ((".bmp", "BMP", {}), (".webp", "WEBP", {}), (".webp", "WEBP", {"lossless": True}), (".ppm", "PPM", {})):
        add(suffix, rgb, kind, **how)
    add(".bmp", rgb.convert("P"), "BMP")
    return made


def damaged(rng: Random, images: list[tuple[str, bytes]]) -> tuple[str, bytes]:
    """One image with one to six damages, mostly near its beginning, where the headers are."""
    suffix, content = rng.choice(images)
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 3, 6))):
        at = min(int(len(data) * rng.random() ** rng.choice((1, 3))), max(len(data) - 1, 0))
        kind = rng.randrange(7)
        if not data:
            break
        if kind == 0:
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            data[at : at + 4] = rng.choice((b"\0\0\0\0", b"\xff" * 4, b"\x7f\xff\xff\xff", b"\0\0\x75\x30", b"\x30\x75\0\0"))
        elif kind == 2:
            del data[at : at + rng.choice((1, 4, 64))]
        elif kind == 3:
            data[at:at] = rng.randbytes(rng.choice((1, 4, 64)))
        elif kind == 4:
            del data[max(at, 1) :]
        elif kind == 5:
            data[at : at + 64] = rng.randbytes(64)
        else:
            other = rng.choice(images)[1]
            data[at:] = other[int(len(other) * rng.random()) :]
    return suffix, with_checksums(bytes(data)) if suffix == ".png" and rng.random() < 0.7 else bytes(data)


def with_checksums(png: bytes) -> bytes:
    """A PNG whose checksums are right again, so that damage is met further in."""
    data, at = bytearray(png), 8
    while at + 12 <= len(data):
        end = at + 8 + int.from_bytes(data[at : at + 4], "big")
        if end + 4 > len(data):
            break
        data[end : end + 4] = zlib.crc32(data[at + 4 : end]).to_bytes(4, "big")
        at = end + 4
    return bytes(data)


def verdict(path: Path, folder: Path | None) -> tuple[str, str]:
    """What reading a file, or the folder it was put into, gives, and why where it must not happen."""
    import numpy as np

    from engine.errors import BadInput
    from engine.puzzles.imagefile import read_image
    from engine.puzzles.piecefolder import read_pieces

    try:
        arrays = [read_image(path)] if folder is None else [piece.image for piece in read_pieces(folder).pieces]
    except BadInput as error:
        words = str(error)
        named = path.name in words or folder is not None
        whole = "\n" not in words and words.endswith(".") and len(words) < LONGEST
        return "sentence" if whole and named else "no sentence", words
    except BaseException as error:
        return "other exception", f"{type(error).__name__}: {error}"
    good = all(a.dtype == np.uint8 and a.ndim == 3 and a.size and a.shape[2] in (3, 4) for a in arrays)
    return ("pixels", "") if good else ("impossible", str([a.shape for a in arrays]))


def child(folder: Path, count: int, seed: int, first: int) -> None:
    """Make and read files from number `first` on, one line of JSON a file, flushed."""
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    images = valid_images()
    for index in range(first, count):
        suffix, content = damaged(Random(f"{seed}/{index}"), images)
        here = folder / f"f{index}"
        here.mkdir(exist_ok=True)
        path = here / f"b{suffix}"
        path.write_bytes(content)
        if index % 4 == 3:
            for name in ("a.png", "c.png"):
                (here / name).write_bytes(images[0][1])
        print(json.dumps({"index": index}), flush=True)
        signal.alarm(SECONDS)
        state, words = verdict(path, here if index % 4 == 3 else None)
        signal.alarm(0)
        print(json.dumps({"index": index, "state": state, "words": words, "suffix": suffix}), flush=True)


def run(count: int, seed: int, folder: Path) -> list[dict[str, object]]:
    """Read `count` damaged files; a child that dies is replaced, and the file it died of is counted."""
    records: list[dict[str, object]] = []
    while len(records) < count:
        command = [sys.executable, __file__, "--child", str(folder), str(count), str(seed), str(len(records))]
        done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2])
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        records += [line for line in lines if "state" in line]
        if lines and "state" not in lines[-1]:
            state = "hang" if done.returncode == -signal.SIGALRM else "killed"
            records.append({"index": lines[-1]["index"], "state": state, "words": done.stderr[-300:], "suffix": ""})
        elif done.returncode or not lines:
            raise RuntimeError(done.stderr)
        elif done.stderr.strip():
            records[-1] = {**records[-1], "state": "stray words", "words": done.stderr[:300]}
    return records


def main() -> int:
    """Run the benchmark and print what came out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        records = run(options.files, options.seed, Path(folder))
        bad = [record for record in records if record["state"] not in ALLOWED]
        for record in bad:
            print(f"{record['index']} {record['suffix']} {record['state']}: {record['words']}")
            if options.keep:
                shutil.copytree(Path(folder) / f"f{record['index']}", options.keep / f"f{record['index']}", dirs_exist_ok=True)
    print(", ".join(f"{state} {number}" for state, number in sorted(Counter(str(r["state"]) for r in records).items())))
    return 1 if bad else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        sys.path.insert(0, str(Path(__file__).parents[2]))
        child(Path(sys.argv[2]), *map(int, sys.argv[3:]))
    else:
        sys.exit(main())
