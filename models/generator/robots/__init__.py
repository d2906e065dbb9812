"""One file per robot: its data and where they come from."""
