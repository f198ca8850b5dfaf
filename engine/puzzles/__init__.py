"""Puzzles: which sub-edges of pieces belong together, and the picture that the pieces make."""
