"""What explains the data, and how well: components in their forms, weighed alone and in sets."""
