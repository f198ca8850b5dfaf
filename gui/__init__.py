"""The window: pages over one state, with views that draw and jobs that work. It imports the engine and annotation."""
