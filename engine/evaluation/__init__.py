"""Evaluation: precision and recall, intervals, tables."""
