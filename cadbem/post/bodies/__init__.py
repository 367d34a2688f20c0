"""Pictures of bodies: frames of a run in; pictures, movies, paths and plots over time out."""
