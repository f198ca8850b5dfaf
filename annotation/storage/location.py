"""Places where a study file is not safe: network disks, on which locks may fail, and folders that a cloud copies."""

import os
import re
import sys
from collections.abc import Iterable
from pathlib import Path

from .places import project_folder, study_file

_NETWORK = {
    "9p", "afpfs", "afs", "ceph", "cifs", "coda", "davfs", "fuse.davfs", "fuse.davfs2", "fuse.glusterfs", "fuse.rclone",
    "fuse.s3fs", "fuse.sshfs", "glusterfs", "gpfs", "lustre", "ncpfs", "nfs", "nfs4", "smb", "smb2", "smb3", "smbfs",
    "vboxsf", "vmhgfs", "webdav",
}  # fmt: skip
_CLOUDS = {
    "Dropbox": r"dropbox", "OneDrive": r"onedrive", "Google Drive": r"google ?drive|my drive|googledrive",
    "iCloud": r"icloud ?drive|mobile documents", "Nextcloud": r"nextcloud", "ownCloud": r"owncloud", "MEGA": r"megasync",
    "pCloud": r"pcloud ?drive", "Box": r"box sync|box-box", "Syncthing": r"syncthing",
}  # fmt: skip
_MARKS = {
    "Dropbox": (".dropbox.cache",), "Nextcloud": (".nextcloudsync.log", "._nextcloudsync.log"),
    "ownCloud": (".owncloudsync.log", "._owncloudsync.log"), "Google Drive": (".tmp.drivedownload", ".tmp.driveupload"),
    "Syncthing": (".stfolder",), "MEGA": (".megaignore",),
}  # fmt: skip


def location_warning(path: Path | str, *, mounts: Path = Path("/proc/mounts")) -> str | None:
    """One sentence where a study file (or its folder) would lie on a network disk or in a cloud folder, or None.

    Servers given by their address are safe. `mounts` is the system's table of mounted disks, where it has one.
    """
    if "://" in str(path):
        return None
    file = study_file(path)
    named = project_folder(file) or file
    kind = network_disk(named.parent, mounts)
    if kind is not None:
        return (
            f"{named} lies on a network disk ({kind}), where two programs may damage a study or lose votes; keep it on a "
            "disk of this computer, or use a PostgreSQL server."
        )
    cloud = cloud_folder(named.parent)
    if cloud is not None:
        return (
            f"{named} lies in a folder of {cloud}, which may copy it in the middle of a vote; keep it elsewhere while it is "
            "voted on, and put a closed copy there."
        )
    return None


def warn_of_place(path: Path | str) -> None:
    """Print the warning, if there is one, on the standard error."""
    sentence = location_warning(path)
    if sentence is not None:
        print(f"concord: {sentence}", file=sys.stderr)


def network_disk(folder: Path, mounts: Path) -> str | None:
    """The kind of network disk that a folder is on, such as "nfs4"."""
    resolved = folder.resolve()
    if str(resolved).startswith(("\\\\", "//")):
        return "a shared folder"
    try:
        table = mounts.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    places = (fields for line in table.splitlines() if len(fields := line.split()) > 2)
    kinds = {Path(_unescaped(place)): kind for _, place, kind, *_ in places}  # a later mount hides an earlier one
    nearest = next((one for one in (resolved, *resolved.parents) if one in kinds), None)
    return kinds[nearest] if nearest is not None and kinds[nearest] in _NETWORK else None


def cloud_folder(folder: Path) -> str | None:
    """Whose cloud folder this is or lies in, by the names and the marks of such folders."""
    resolved = folder.resolve()
    for cloud, name in _CLOUDS.items():
        if _has_part((folder.absolute(), resolved), rf"({name})([ (-].*)?"):
            return cloud
    for parent in (resolved, *resolved.parents):
        for cloud, marks in _MARKS.items():
            if any(os.path.lexists(parent / mark) for mark in marks):
                return cloud
    return None


def _has_part(paths: Iterable[Path], name: str) -> bool:
    return any(re.fullmatch(name, part, re.IGNORECASE) for path in paths for part in path.parts)


def _unescaped(place: str) -> str:
    """A path as the table of mounts writes it, spaces and the like as octal numbers."""
    return re.sub(r"\\([0-7]{3})", lambda found: chr(int(found[1], 8)), place)
