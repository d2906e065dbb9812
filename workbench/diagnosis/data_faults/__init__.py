"""What the data have wrong: points, targets, set-ups and loads that are not as stated."""
