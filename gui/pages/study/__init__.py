"""What a researcher does with a study: making one, its volunteers, packets and exports."""
