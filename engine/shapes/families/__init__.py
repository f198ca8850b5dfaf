"""Families of shapes with known truth, generated from a seed."""

from .collection import make_collection, parse_segments, write_pair, write_shape
from .generated import FAMILIES, LABELS, POSES, VARIANTS, GeneratedShape, make_shape
from .pairs import GeneratedPair, make_pair

__all__ = [
    "FAMILIES",
    "LABELS",
    "POSES",
    "VARIANTS",
    "GeneratedPair",
    "GeneratedShape",
    "make_collection",
    "make_pair",
    "make_shape",
    "parse_segments",
    "write_pair",
    "write_shape",
]
