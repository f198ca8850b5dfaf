"""Judging: volunteers vote on matches, every vote is kept, and majorities become precision tables.

`annotation.study` is the service that a window or a command line calls. Nothing here imports Qt or VTK.
"""
