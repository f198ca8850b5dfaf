"""What the votes say: precision, agreement, comparisons, volunteers, as tables and reports."""
