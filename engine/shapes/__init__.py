"""Shapes: from two segmented meshes to consistent matches between their segments and unions of segments."""
