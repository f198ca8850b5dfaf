"""Volunteers and their votes: what comes next, every answer as an event, majorities."""
