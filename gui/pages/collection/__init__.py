"""The page of many shapes matched together."""
