"""What a file says of its faces: entities in; names, layers and colours of faces out."""
