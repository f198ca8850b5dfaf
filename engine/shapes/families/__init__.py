"""Families of shapes with known truth, generated from a seed."""

from .generated import FAMILIES, LABELS, POSES, VARIANTS, GeneratedShape, make_shape
from .pairs import GeneratedPair, make_pair

__all__ = ["FAMILIES", "LABELS", "POSES", "VARIANTS", "GeneratedPair", "GeneratedShape", "make_pair", "make_shape"]
