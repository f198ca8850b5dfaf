"""The voting screen: one match, one question, keys only."""
