"""How the robots look: shapes drawn around the joint axes. Not the manufacturers' shapes."""
