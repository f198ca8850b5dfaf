"""The errors that a user can meet: each carries one sentence that says what is wrong, where, and what to do."""


class ConcordError(Exception):
    """Base of all errors that Concord raises on purpose; its text is shown to people as it stands."""


class BadInput(ConcordError):
    """A file, a mesh, labels or a folder that cannot be used."""


class BadParameter(ConcordError):
    """An unknown parameter or preset, or a value out of its range."""


class Cancelled(ConcordError):
    """Raised inside a progress callback by whoever wants the work to stop."""

    def __init__(self) -> None:
        super().__init__("The work was cancelled.")
