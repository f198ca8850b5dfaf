"""Views: each shows one thing and reports what was clicked; none of them owns the state."""
