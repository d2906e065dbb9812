"""Studies: the demo, the published ones, and the blind one that measures our own error rates."""

PUBLISHED = ("cylindrical", "kr500", "kr120", "rx170", "longlink")
