"""What the points scatter by: as stated, as repeats show, or as what is left."""
