"""The page of a puzzle: its pieces, joins and solutions."""
