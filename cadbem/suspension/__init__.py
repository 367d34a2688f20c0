"""Bodies that flow along: interfaces, droplets, their motion in time."""
