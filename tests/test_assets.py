"""What ships with Concord: the picture is the one whose licence stands beside it."""

import hashlib

from PIL import Image

from assets import example_picture


def test_the_picture_is_the_one_that_its_licence_speaks_of():
    path = example_picture()
    stated = (path.parent / "README.md").read_text(encoding="utf-8")
    assert hashlib.sha256(path.read_bytes()).hexdigest() in stated
    assert "public domain" in stated
    with Image.open(path) as picture:
        assert picture.size == (512, 600)
        picture.load()
