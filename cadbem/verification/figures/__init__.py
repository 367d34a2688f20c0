"""What workflows print and draw beside the thesis's numbers and true ones: a file a figure."""
