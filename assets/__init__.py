"""Files that ship with Concord: the example shapes and the example picture."""

from pathlib import Path

ORDER = ("lamps", "vases", "candles", "aeroplanes", "animals", "lamps-welded")


def folder() -> Path:
    """The folder of the bundled files."""
    return Path(__file__).resolve().parent


def example_pairs() -> list[tuple[str, Path, Path]]:
    """Name, source mesh and target mesh of each bundled pair, the lamps first.

    Labels (`.seg`) and truth (`.sem`) stand beside each mesh, the names of the classes in its folder's `labels.json`.
    """
    found = []
    for name in ORDER:
        source = next((folder() / "examples" / name).glob("*_a.off"))
        found.append((name, source, source.with_name(source.name.replace("_a.off", "_b.off"))))
    return found


def example_picture() -> Path:
    """The bundled picture for puzzles, a portrait in the public domain (its licence stands beside it)."""
    return folder() / "pictures" / "grace_hopper.jpg"
