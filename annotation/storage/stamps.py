"""What every row is stamped with: when, and by which version."""

import functools
from datetime import UTC, datetime
from importlib import metadata


def now() -> str:
    """The time in UTC, to the microsecond, in ISO 8601; sorts as text."""
    return datetime.now(UTC).isoformat(timespec="microseconds")


@functools.cache
def app_version() -> str:
    """The installed version, or "unknown" when run from a folder that is not installed."""
    try:
        return metadata.version("concord-correspondences")
    except metadata.PackageNotFoundError:
        return "unknown"
