"""A plan that can be driven: poses that are free, seen and reached, in an order that takes little time."""
