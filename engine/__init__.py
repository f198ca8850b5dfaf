"""The headless engine: shapes, consistency and evaluation. It imports neither Qt nor VTK."""
