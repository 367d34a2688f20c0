"""Pictures of a channel in space: a boundary or a solution in; a picture of faces or flow out."""
