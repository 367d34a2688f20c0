"""What the verification page says of each table and figure of the thesis, in order.

Numbers are not here: they come from the checks of ``cadbem verify`` and from docs/results.md.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Item:
    """A table or figure: the ``place`` that its checks have, what it ``shows``, ``pictures`` of
    docs/pictures, ``blocks`` of docs/results.md as (section, first words), a ``remark``."""

    place: str
    shows: str
    pictures: tuple[str, ...] = ()
    blocks: tuple[tuple[str, str], ...] = ()
    remark: str = ""


LOST = "The figure itself is not at hand, only what the text says of it."
SKETCH = "A sketch without numbers; "
CHANNEL, SPHERE = "Square channel", "Moving sphere"
SHEAR, PLATES = "Droplet in shear flow", "Droplet between plates"
PLANE, PLANE_PLATES = "Plane droplet in shear flow", "Plane droplet between plates"
TWO, FAR = "Two plane droplets between plates", "Plane droplet far from a circle"
JUNCTION = "Bodies in the Y-junction"

ITEMS = (
    Item("Figure 2.1", "linear B-splines, a square", ("verification_square",)),
    Item("Figure 2.2", "quadratic B-splines, not quite a circle", ("verification_bspline_circle",)),
    Item("Figure 2.3", "knots inserted", ("verification_knots_inserted",)),
    Item("Figure 2.4", "degree raised", ("verification_degree_raised",)),
    Item("Figure 2.5", "NURBS, a circle", ("verification_nurbs_circle",)),
    Item("Figure 2.6", "heat in a quarter ring: control points, collocation points, elements",
         ("verification_ring",), remark="Our collocation points lie strictly inside the sides."),
    Item("Figure 2.7", "temperature in the ring", ("annulus_heat",)),
    Item("Figure 2.8", "its convergence", (), (("Heat in a quarter of an annulus", "degree"),),
         "The thesis reads about 0.1 % from one element a side, and 1e-5 % at the finest; its "
         "points are not ours, so that only the order of magnitude can be compared."),
    Item("Figure 2.9", "a B-spline surface and its parameters", ("verification_mapping",),
         remark=f"{SKETCH}ours is another surface."),
    Item("Figure 2.10", "a cylinder cut for a point nearby", ("verification_cylinder",)),
    Item("Table 2.1", "an integral over the cylinder",
         remark="Ours holds its tolerance at any distance. The thesis's rule gives its own printed "
         "values; at δ = 2.2 that rule asks for 2 × 2 parts, but the thesis prints 1 × 1."),
    Item("Figure 2.11", "an octant of a sphere cut in three", ("verification_octant",)),
    Item("Table 2.2", "an integral over the octant"),
    Item("Figure 2.12", "polar coordinates in triangles", ("verification_triangles",)),
    Item("Table 2.3", "a weakly singular integral",
         remark="The thesis names 20 points a direction; its values are those of 10."),
    Item("Figure 2.13", "elements on a sphere", ("verification_sphere",),
         remark="Ours has six patches and no poles."),
    Item("Figure 2.14", "heat in a hollow sphere", ("hollow_sphere_heat",),
         (("Heat in a hollow sphere", "convection"),)),
    Item("Figure 2.15", "the square channel", ("square_channel_collocation",)),
    Item("Figure 2.16", "velocity at its outlet", ("verification_outlet",)),
    Item("Figure 2.17", "net flux and net force", ("verification_channel_convergence",),
         remark="Ours imposes that what enters leaves, so that the net flux is that of rounding."),
    Item("Figure 2.18", "pressure gradient", remark="Right half of the picture above. The exact "
         "flow has weak singularities in its corners; graded elements resolve them."),
    Item("Eq. 2.55", "a channel twice as wide as high",
         remark="As printed the formula is wrong unless the channel is square: the reference is "
         "the corrected one."),
    Item("Figure 2.19", "drag of a moving sphere", ("verification_drag",),
         remark="The traction of a moving sphere lies in the span of ours, which makes the error "
         "that of rounding; the picture has a flow where it does not."),
    Item("Figure 2.20", "speed around a moving sphere", ("moving_sphere_speed",)),
    Item("Figure 3.1", "an ellipse that relaxes", ("ellipse_relaxation",),
         (("Ellipse that relaxes to a circle", "N = 32"),)),
    Item("Figure 3.2", "shear flow, with and without correction of the area",
         ("droplet_shear_2d",), ((PLANE, "Ca ="),),
         "The thesis's Ca is twice the true one in a plane; with that reading its D is right."),
    Item("Figure 3.3", "mesh relaxation far from a circle",
         ("droplet_high_deformation_2d_deformation", "droplet_high_deformation_2d_shapes"),
         ((FAR, "Ca ="),)),
    Item("Figure 3.4", "D between plates", ("droplet_between_plates_2d_deformation",),
         ((PLANE_PLATES, "Ca ="),),
         f"{LOST} That W = 16 is like no plates at all, it says, and so it nearly is."),
    Item("Figure 3.5", "two droplets between plates", ("two_droplets_2d_pass_filmstrip",),
         ((TWO, "Ca ="),), f"{LOST} As there, the droplets pass each other and do not touch."),
    Item("Figure 4.1", "D and volume, Ca = 0.2, λ = 1", ("droplet_shear_volume",),
         ((SHEAR, "Ca = 0.2"),),
         "The thesis measures its D against Cox's formula, which is well below the truth."),
    Item("Figure 4.2", "volume for other viscosity ratios",
         remark="The thesis's way, run by us, is in the table above."),
    Item("Figure 4.3", "shapes with and without mesh relaxation, Ca = 0.35",
         ("droplet_shear_shape_ours", "droplet_shear_shape_thesis",
          "droplet_shear_shape_thesis_relaxed"), ((SHEAR, "Ca = 0.35"),)),
    Item("Table 4.1", "D(5) at Ca = 0.35 and 0.4", (), ((SHEAR, "Table 4.1"),),
         "The thesis takes 802 points as the truth; the spectral computation, where there is "
         "one, is above it. Times of one step are not compared: ours are those of whole runs."),
    Item("Figure 4.4", "a droplet drawn out, Ca = 0.5, λ = 0.1",
         tuple(f"droplet_elongation_shape_{t}" for t in ("00.0", "04.0", "08.0", "12.0")),
         (("Droplet drawn out by shear flow", ""),),
         "The thesis's growth of the surface is not confirmed: two resolutions of ours agree with "
         "each other and not with it."),
    Item("Figure 4.5", "steady D in extension, λ = 10", ("droplet_extension",),
         (("Viscous droplet in extension", "λ = 10"),),
         "The thesis finds that singularity subtraction fails above Ca = 0.07; ours does not, on "
         "splines of degree 2 either."),
    Item("Figure 4.6", "elements on a plate", ("verification_plate",)),
    Item("Figure 4.7", "steady D against confinement", ("verification_confinement",),
         ((PLATES, "Ca = 0.2, λ = 1\nR / W"),), "W is half the distance of the plates."),
    Item("Figure 4.8", "D between close plates", ("droplet_between_plates_deformation",),
         ((PLATES, "Ca = 0.2, λ = 1, R"),)),
    Item("Figure 4.9", "the Y-junction", ("y_junction_faces",),
         remark="The thesis does not give all lengths: see the drawing in geometries/."),
    Item("Figure 4.10", "paths of a droplet and of a particle", ("y_junction_bodies_paths",),
         ((JUNCTION, "distance"),),
         f"{LOST} That the heights stay in the middle, z = 2, it says, and they do."),
    Item("Figure 4.11", "the droplet at the end", ("y_junction_bodies_droplet",), remark=LOST),
    Item("Beyond", "not in the thesis: bodies, and walls nearby", (), ((SPHERE, "sphere near"),)),
)  # fmt: skip
