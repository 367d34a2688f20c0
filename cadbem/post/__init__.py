"""Pictures and files of boundaries and flows."""

from cadbem.post.bodies.droplets import draw_droplets, draw_outlines, write_droplets
from cadbem.post.bodies.movie import draw_movie, draw_scene, filmstrip
from cadbem.post.bodies.paths import draw_paths
from cadbem.post.bodies.series import write_channel, write_frame, write_frames, write_index
from cadbem.post.bodies.time_series import draw_series
from cadbem.post.bodies.trajectories import draw_trajectories
from cadbem.post.channel.view_around import draw_around
from cadbem.post.channel.view_boundary import draw_boundary, draw_collocation
from cadbem.post.channel.view_flow import draw_flow, draw_slices, draw_streamlines
from cadbem.post.channel.view_walls import draw_traction
from cadbem.post.fields.bezier import bezier_grid
from cadbem.post.fields.cells import edge_lines, tessellated, wall_stresses
from cadbem.post.fields.frames import Frame
from cadbem.post.fields.volume import volume_grid
from cadbem.post.files.export import write_mesh, write_vtu
from cadbem.post.run_pictures import draw_run
from cadbem.post.solution_pictures import draw_solution
from cadbem.post.style.display import require_display

__all__ = [
    "Frame",
    "bezier_grid",
    "draw_around",
    "draw_boundary",
    "draw_collocation",
    "draw_droplets",
    "draw_flow",
    "draw_movie",
    "draw_outlines",
    "draw_paths",
    "draw_run",
    "draw_scene",
    "draw_series",
    "draw_slices",
    "draw_solution",
    "draw_streamlines",
    "draw_traction",
    "draw_trajectories",
    "edge_lines",
    "filmstrip",
    "require_display",
    "tessellated",
    "volume_grid",
    "wall_stresses",
    "write_droplets",
    "write_channel",
    "write_frame",
    "write_frames",
    "write_index",
    "write_mesh",
    "write_vtu",
]
