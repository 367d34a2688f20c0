"""Elements for adaptive solutions: a boundary as drawn in; one with patches of one element, sized
by the channel's width and graded towards re-entrant edges, and refined where it is asked, out."""
