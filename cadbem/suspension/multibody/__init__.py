"""All bodies at once: bodies in surroundings in; velocities, gaps, measures, fields out."""
