"""What is asked of whom: samples, gold and practice, top-ups, and how many votes are enough."""
