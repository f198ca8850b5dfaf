"""What every Concord command does alike: one sentence and exit code 2 on bad input, and a progress bar."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import BadParameter, Cancelled, ConcordError
from .progress import Progress
from .store import output_folder

if TYPE_CHECKING:
    from cyclopts import App, Token


def run(app: "App", arguments: Sequence[str] | None = None) -> int:
    """Run a command-line application and return its exit code: 0 done, 2 bad input, 130 interrupted."""
    from cyclopts import CycloptsError

    app.suppress_keyboard_interrupt = False  # it is answered below, in our own words
    try:
        result = app(arguments, exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        return complain(_words(error))
    except (KeyboardInterrupt, Cancelled):
        print("concord: stopped.", file=sys.stderr)
        return 130
    except ConcordError as error:
        return complain(str(error))
    except BrokenPipeError:
        return 0
    except MemoryError:
        return complain("There is not enough memory for this; use a smaller mesh or picture, or lower node_cap.")
    return result if isinstance(result, int) else 0


def _words(error: Exception) -> str:
    """What the command line says of a wrong option; of a declared parameter, what that takes."""
    from pydantic import ValidationError

    from .parameters import Parameters, sentence

    model = getattr(getattr(error, "argument", None), "hint", None)
    if isinstance(error.__cause__, ValidationError) and isinstance(model, type) and issubclass(model, Parameters):
        return sentence(model, error.__cause__)
    return " ".join(str(error).split())


def whole_number(_: object, tokens: "Sequence[Token]") -> int:
    """Read an option that takes whole numbers alone, which would otherwise be rounded in silence."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise BadParameter(f"{tokens[0].keyword} takes a whole number, not {tokens[0].value!r}.") from None


def complain(sentence: str) -> int:
    """Print one sentence on the standard error and return the exit code of bad input."""
    print(f"concord: {sentence}", file=sys.stderr)
    return 2


@contextmanager
def progress_bar() -> Iterator[Progress]:
    """A progress bar with the time left on the standard error; plain silence where that is not a terminal."""
    from rich import progress as rich_progress
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description:<40}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with rich_progress.Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting", total=1.0)
        yield lambda share, words: bar.update(task, completed=share, description=words[:40])


@contextmanager
def results_folder(path: Path) -> Iterator[Path]:
    """The folder for results, proven writable before any long work; where that fails, no empty folder is left behind.

    Only folders made here are removed again, and only while nothing is in them.
    """
    made = [folder for folder in (path, *path.parents) if not folder.exists()]
    try:
        yield output_folder(path)
    except BaseException:
        for folder in made:
            with suppress(OSError):
                folder.rmdir()
        raise
