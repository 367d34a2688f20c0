"""Labels of faces: entities of a file in; names, layers and colours of faces out."""
