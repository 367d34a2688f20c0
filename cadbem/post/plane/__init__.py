"""Pictures in a plane: a plane channel, or the plan of one in space, in; axes with it out."""
