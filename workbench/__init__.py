"""Robot accuracy workbench."""
