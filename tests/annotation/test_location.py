"""Warnings of places where a study is not safe."""

import pytest
from judging_world import LAMP, VASE, identity, study_of

from annotation.storage.location import cloud_folder, location_warning, network_disk


def mounted(tmp_path, **kinds: str):
    """A table of mounted disks: the root is local, a folder of each name is of that kind."""
    table = tmp_path / "mounts"
    lines = ["/dev/sda1 / ext4 rw 0 0"]
    for name, kind in kinds.items():
        (tmp_path / name.replace("_", " ")).mkdir()
        place = str(tmp_path / name.replace("_", " ")).replace(" ", "\\040")
        lines.append(f"server:/export {place} {kind} rw,relatime 0 0")
    table.write_text("\n".join(lines) + "\n")
    return table


def test_a_folder_of_this_computer_is_quiet(tmp_path):
    assert location_warning(tmp_path / "a.db", mounts=mounted(tmp_path, usb="vfat")) is None
    assert location_warning(tmp_path / "usb" / "a.db", mounts=tmp_path / "mounts") is None
    assert location_warning("postgresql://host/nextcloud") is None


@pytest.mark.parametrize("kind", ["nfs4", "cifs", "fuse.sshfs", "9p"])
def test_a_network_disk_is_told(tmp_path, kind):
    table = mounted(tmp_path, my_share=kind)
    folder = tmp_path / "my share" / "deeper"
    assert network_disk(folder, table) == kind
    sentence = location_warning(folder / "lamps.concord", mounts=table)
    assert f"lamps.concord lies on a network disk ({kind})" in sentence
    assert sentence.endswith(".")
    assert sentence.count(". ") == 0


def test_the_nearest_mount_decides(tmp_path):
    table = mounted(tmp_path, share="nfs")
    (tmp_path / "share" / "local").mkdir()
    with table.open("a") as lines:
        lines.write(f"/dev/sdb1 {tmp_path}/share/local ext4 rw 0 0\n/dev/sdc1 {tmp_path}/share xfs rw 0 0\n")
    assert network_disk(tmp_path / "share" / "local", table) is None
    assert network_disk(tmp_path / "share", table) is None  # mounted over


@pytest.mark.parametrize(
    ("folder", "cloud"),
    [
        ("Dropbox/study", "Dropbox"), ("Dropbox (Personal)", "Dropbox"), ("OneDrive - University of X/a", "OneDrive"),
        ("CloudStorage/GoogleDrive-me@example.org/My Drive", "Google Drive"), ("Nextcloud", "Nextcloud"),
        ("Library/Mobile Documents/com~apple~CloudDocs", "iCloud"),
    ],
)  # fmt: skip
def test_cloud_folders_by_name(tmp_path, folder, cloud):
    (tmp_path / folder).mkdir(parents=True)
    assert cloud_folder(tmp_path / folder) == cloud
    assert f"in a folder of {cloud}" in location_warning(tmp_path / folder / "a.db")


@pytest.mark.parametrize(
    ("mark", "cloud"), [(".nextcloudsync.log", "Nextcloud"), (".stfolder", "Syncthing"), (".dropbox.cache", "Dropbox")]
)
def test_cloud_folders_by_their_marks(tmp_path, mark, cloud):
    (tmp_path / "work" / "deep").mkdir(parents=True)
    assert location_warning(tmp_path / "work" / "deep" / "a.db") is None
    (tmp_path / "work" / mark).touch()
    assert cloud_folder(tmp_path / "work" / "deep") == cloud
    assert cloud_folder(tmp_path) is None


def test_a_link_into_a_cloud_folder_is_seen(tmp_path):
    (tmp_path / "Nextcloud" / "studies").mkdir(parents=True)
    (tmp_path / "studies").symlink_to(tmp_path / "Nextcloud" / "studies")
    assert cloud_folder(tmp_path / "studies") == "Nextcloud"


def test_names_that_only_resemble(tmp_path):
    for name in ("dropboxes", "my-onedrive-notes", "box", "drive"):
        (tmp_path / name).mkdir()
        assert cloud_folder(tmp_path / name) is None


def test_the_command_line_tells_it_and_goes_on(tmp_path, capsys):
    from annotation.__main__ import main

    (tmp_path / "Nextcloud").mkdir()
    for folder, told in ((tmp_path / "Nextcloud", True), (tmp_path, False)):
        file = folder / "lamps.concord"
        study_of(file).close()
        item = identity(LAMP, (0,), VASE, (0,))
        assert main(["vote", str(file), "--volunteer", "anna", "--item", item, "--answer", "correct"]) == 0
        said = capsys.readouterr()
        assert said.out == "Saved.\n"
        assert said.err.startswith(f"concord: {file} lies in a folder of Nextcloud") == told
        assert bool(said.err) == told
