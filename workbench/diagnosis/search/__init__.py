"""The search for what explains the data, round by round."""
