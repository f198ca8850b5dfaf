"""Packets out and back, merging, exports, archives, and deleting a volunteer."""
