"""The hall: candidates and how well two of them agree. It knows neither meshes nor images."""
