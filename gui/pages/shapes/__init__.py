"""The page of two shapes: their matches, parameters, judging and wishes."""
