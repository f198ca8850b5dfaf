"""The architecture is a test: directions of imports, no circles, no Qt or VTK below the window."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("engine", "annotation", "gui", "assets")
MAY_IMPORT = {
    "engine": {"engine", "assets"},
    "annotation": {"annotation", "engine", "assets"},
    "gui": {"gui", "annotation", "engine", "assets"},
    "assets": {"assets"},
}
WINDOW_LIBRARIES = {"PySide6", "vtk", "vtkmodules", "pyvista", "pyvistaqt", "qtawesome", "pyqtgraph"}


def sources():
    return [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]


def imported(path: Path) -> set[str]:
    """Absolute names of all modules that a file imports, also inside functions."""
    module = path.relative_to(ROOT).with_suffix("").parts
    here = module[:-1]
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else ()
            stem = ".".join([*base, *([node.module] if node.module else [])])
            found |= {stem} | {f"{stem}.{alias.name}" for alias in node.names}
    return found


def test_every_package_has_sources():
    assert {path.relative_to(ROOT).parts[0] for path in sources()} == set(PACKAGES)


@pytest.mark.parametrize("path", sources(), ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_go_one_way(path):
    package = path.relative_to(ROOT).parts[0]
    used = {name.split(".")[0] for name in imported(path)}
    assert used & set(PACKAGES) <= MAY_IMPORT[package]
    if package != "gui":
        assert not used & WINDOW_LIBRARIES


def test_the_hall_knows_neither_wing():
    for path in (ROOT / "engine" / "consistency").glob("*.py"):
        assert not [name for name in imported(path) if name.startswith(("engine.shapes", "engine.puzzles"))], path


def project_imports(path: Path, modules) -> set[str]:
    """Modules of the project that a file imports, also inside functions, but not for type checkers alone."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    here = path.relative_to(ROOT).with_suffix("").parts[:-1]
    checking = {id(inner) for node in ast.walk(tree) if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)
                for inner in ast.walk(node)}  # fmt: skip
    found = set()
    for node in ast.walk(tree):
        if id(node) in checking:
            continue
        if isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else ()
            stem = ".".join([*base, *([node.module] if node.module else [])])
            names = {f"{stem}.{alias.name}" for alias in node.names}
            found |= names & modules.keys() or {stem}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


def test_no_import_circles():
    modules = {".".join(p.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): p for p in sources()}
    graph = {name: {m for m in project_imports(path, modules) if m in modules and m != name} for name, path in modules.items()}
    done, trail = set(), []

    def visit(name):
        assert name not in trail, " -> ".join([*trail[trail.index(name):], name])
        if name in done:
            return
        trail.append(name)
        for following in sorted(graph[name]):
            visit(following)
        trail.pop()
        done.add(name)

    for name in sorted(graph):
        visit(name)


def test_importing_the_engine_loads_neither_qt_nor_vtk():
    modules = [".".join(p.relative_to(ROOT).with_suffix("").parts) for p in sources()
               if p.relative_to(ROOT).parts[0] in ("engine", "annotation") and p.name not in ("__init__.py",)]  # fmt: skip
    code = f"import sys, importlib\nfor m in {modules!r}: importlib.import_module(m)\nprint(' '.join(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout
    assert not {name.split(".")[0] for name in loaded.split()} & WINDOW_LIBRARIES


def test_no_pickle_and_no_path_of_a_machine():
    for path in sources():
        text = path.read_text(encoding="utf-8")
        assert "import pickle" not in text and "allow_pickle=True" not in text, path  # noqa: PT018
        assert "/home/" not in text, path
