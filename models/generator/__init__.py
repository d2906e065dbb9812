"""Makes the robots under `models/`: data, kinematics, shapes, files."""
