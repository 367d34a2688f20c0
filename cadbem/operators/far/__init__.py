"""Bodies seen from afar: their layers in; a few equivalent sources for distant targets out."""
