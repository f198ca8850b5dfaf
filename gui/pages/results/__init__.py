"""The page of what the votes say."""
