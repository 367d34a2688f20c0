"""Files: grids and pictures in; ``.vtu``, meshes and movies on disk out."""
