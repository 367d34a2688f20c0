"""Far fields of bodies: their layers in; a few equivalent sources for distant targets out."""
