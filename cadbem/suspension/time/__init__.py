"""Motion in time: bodies and a step rule in; states, checkpoints and the history of a run out."""
