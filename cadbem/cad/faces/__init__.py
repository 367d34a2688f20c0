"""One face of the model: its BREP record in; surface, edges and areas as exact NURBS out."""
