"""The style of all pictures: sizes and quantities in; colours, fonts, legends, panels out."""
