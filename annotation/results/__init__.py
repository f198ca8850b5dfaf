"""Results of matching and solving as matches of a study, and back again."""
