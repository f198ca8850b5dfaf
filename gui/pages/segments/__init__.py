"""The editor of segments."""
