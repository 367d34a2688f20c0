"""Makes docs/gallery.md and its pictures, docs/pictures/gallery_*: 5 to 10 minutes.

    python docs/gallery.py                   everything
    python docs/gallery.py faces flow ...    some pictures, and the page

Each function below makes one picture.  The page shows its first line as title, the rest of its
docstring, and its body as the script that makes the picture.
"""

import inspect
import re
import shutil
import sys
import tempfile
import textwrap
import time
from contextlib import chdir
from pathlib import Path

import numpy as np

import cadbem as cb

HERE = Path(__file__).resolve().parent
PICTURES = HERE / "pictures"
HEAD = """# Gallery

One picture a thing, with the lines that make it. They are run from the project's folder, after
`import cadbem as cb` and `import numpy as np`. `python docs/gallery.py` makes the pictures and this
page. What draws quantities takes `units=` (anything with `length`, `time` and `pressure`, such as
`cb.Units()`), which colour bars and axes then name; without them they give the CAD file's unit of
length and leave time and viscosity open. No screen is needed.
"""


def faces():
    """Which face is which

    Numbers are those that `channel.named(inlet=2, ...)` takes. Faces that hide behind others get
    further views, those seen from nowhere one through the walls; `cadbem view FILE -o PNG` does the
    same.
    """
    channel = cb.read_cad("geometries/t_junction.step")
    cb.draw_boundary(channel, "faces.png")


def unnamed():
    """A file without names

    Faces have a tint each; thin lines divide them into patches.
    """
    channel = cb.read_cad("geometries/bent_pipe.igs")
    cb.draw_boundary(channel.named(rest=""), "unnamed.png")


def edges():
    """Edges of a plane channel"""
    plan = cb.read_outline("geometries/t_junction.step")
    cb.draw_boundary(plan, "edges.png")


def collocation():
    """Elements and collocation points

    Those that `solve(accuracy=1e-3)` chose: one element to a patch, small towards the two edges
    that the fluid goes around.
    """
    channel = cb.read_cad("geometries/t_junction.step")
    ends = {name: cb.Inflow(mean_velocity=1.0) for name in ("inlet_a", "inlet_b")}
    ends |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    solution = cb.StokesProblem(channel, 1.0, ends).solve(accuracy=1e-3)
    cb.draw_collocation(solution.space, "collocation.png")


def flow():
    """Flow through a channel

    Speed and pressure on the middle plane, speed on cross-sections, streamlines. The flow is
    sampled where the picture needs it; there is no mesh to make.
    """
    channel = cb.read_cad("geometries/t_junction.step")
    u = cb.Units.of(channel)
    ends = {
        "inlet_a": cb.Inflow(flow_rate=u("30 uL/min")),
        "inlet_b": cb.Inflow(flow_rate=u("10 uL/min")),
        "outlet": cb.Pressure(0.0),
        "walls": cb.NoSlip(),
    }
    solution = cb.StokesProblem(channel, u("1 mPa s"), ends).solve(accuracy=1e-2)
    cb.draw_flow(solution, "flow.png", units=u)


def pdms():
    """The room in a chip: a PDMS block with punched wells, on glass

    `between=` picks mouths by number, as `cadbem info` lists them, by a point, or by a face; block
    and slide close the channel together.
    """
    chip = "geometries/chips/pdms_block.step"
    room = cb.read_cad(chip, between=((1, 2, 2), (5, 2, 2))).named(rest="walls")
    ends = {"mouth_1": cb.Inflow(mean_velocity=1.0), "mouth_2": cb.Pressure(0.0)}
    solution = cb.StokesProblem(room, 1.0, ends | {"walls": cb.NoSlip()}).solve(accuracy=3e-2)
    cb.draw_flow(solution, "pdms.png")


def luer():
    """A Luer hub with a stub"""
    room = cb.read_cad("geometries/chips/luer.step", between=("mouth 1", "mouth 2"))
    room = room.named(rest="walls")
    ends = {"mouth_2": cb.Inflow(mean_velocity=1.0), "mouth_1": cb.Pressure(0.0)}
    solution = cb.StokesProblem(room, 1.0, ends | {"walls": cb.NoSlip()}).solve(accuracy=3e-2)
    cb.draw_flow(solution, "luer.png")


def manifold():
    """A manifold of three bodies

    `fluid="void"` takes the only room in them, with all its mouths.
    """
    room = cb.read_cad("geometries/chips/manifold.step", fluid="void").named(rest="walls")
    ends = {f"port_{k}": cb.Pressure(0.0) for k in (2, 3, 4)} | {"walls": cb.NoSlip()}
    ends["port_1"] = cb.Inflow(mean_velocity=1.0)
    cb.draw_flow(cb.StokesProblem(room, 1.0, ends).solve(accuracy=3e-2), "manifold.png")


def mixer():
    """A mask drawn as DXF

    With a height, an outline becomes a channel; it has ports where it meets the frame.
    """
    channel = cb.read_layout("geometries/chips/mixer.dxf", height=50, layer="channels")
    u = cb.Units.of(channel)
    ends = {f"port_{k}": cb.Inflow(flow_rate=u("1 uL/min")) for k in (1, 2)}
    ends |= {"port_3": cb.Pressure(0.0), "walls": cb.NoSlip()}
    problem = cb.StokesProblem(channel.named(rest="walls"), u("1 mPa s"), ends)
    cb.draw_flow(problem.solve(accuracy=3e-2), "mixer.png", units=u)


def plane_flow():
    """Flow in a plane"""
    plan = cb.read_outline("geometries/flow_focusing.step")
    ends = {name: cb.Inflow(mean_velocity=1.0) for name in ("inlet", "side_a", "side_b")}
    ends |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    solution = cb.StokesProblem(plan, 1.0, ends).solve(accuracy=1e-3)
    cb.draw_flow(solution, "plane_flow.png")


def walls():
    """Pressure and shear stress on walls

    One sees the inner side of the far walls, from two opposite corners.
    """
    channel = cb.read_cad("geometries/constriction.step")
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    solution = cb.StokesProblem(channel, 1.0, ends).solve(accuracy=1e-3)
    cb.draw_traction(solution, "walls.png")


def paths():
    """Paths as tubes

    Of tracers, coloured by the time that they took; `values=` may be their speed as well. Bodies'
    paths are drawn alike.
    """
    channel = cb.read_cad("geometries/bent_pipe.step")
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    solution = cb.StokesProblem(channel, 1.0, ends).solve(accuracy=1e-2)
    tracers = cb.trace(solution, cb.inlet_points(solution, count=40), time_limit=8.0)
    paths, times = tracers.paths, tracers.moments
    cb.draw_paths("paths.png", channel, paths, values=times, label="time", units=cb.Units())


def around():
    """Flow around bodies"""
    ball = cb.Boundary(tuple(cb.Patch(s, "ball") for s in cb.sphere()))
    motion = {"ball": cb.RigidMotion((1.0, 0.0, 0.0))}
    cb.draw_around(cb.StokesProblem(ball, 1.0, motion).solve(accuracy=1e-3), "around.png")


def droplet():
    """A droplet, coloured by its mean curvature"""
    drop = cb.Droplet(cb.spline_sphere(points=392), cb.capillary_tension(0.3))
    *_, last = cb.Simulation(cb.FreeFlow(cb.shear()), drop).run(5.0, every=1.0)
    cb.draw_droplets("droplet.png", [last.droplet.shape])


def velocity():
    """Bodies, coloured by a field

    Here by the velocity of the interface; any coefficients on the droplet will do.
    """
    drop = cb.Droplet(cb.spline_sphere(points=200), cb.capillary_tension(0.3))
    *_, last = cb.Simulation(cb.FreeFlow(cb.shear()), drop).run(3.0, every=1.0)
    fields = {1: {"velocity": last.response.velocity}}
    cb.draw_scene("velocity.png", None, last.shapes, fields=fields, colour="velocity")


def passage():
    """A run: movie, film strip, plots over time

    Colours have the same limits at all times. A name that ends in `.mp4` makes an MP4. The droplet
    comes near the walls: there elements are given by hand, as small as its distance from them.
    """
    channel = cb.read_cad("geometries/constriction.step")
    ends = {"inlet": cb.Inflow(mean_velocity=1.0), "outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    flow = cb.ChannelFlow(cb.StokesProblem(channel.elevated(2).refined(size=0.4), 1.0, ends))
    drop = cb.Droplet(cb.spline_sphere(0.36, (-2.5, 0, 0), points=128), cb.SurfaceTension(20.0))
    run = cb.record(cb.Simulation(flow, drop).run(10.0, every=0.05))
    frames = [cb.Frame(state.time, state.shapes) for state in run.states]
    cb.draw_movie("passage.gif", channel, frames, colour="mean curvature")
    cb.filmstrip("strip.png", channel, frames, 4, colour="mean curvature")
    x, speed = run.track(1)[1][0], np.gradient(run.track(1)[1][0], run.times)
    series = {"Taylor's D": {1: run.deformation}, "x (mm)": {1: x}, "speed": {1: speed}}
    cb.draw_series("series.png", run.times, series)


def junction():
    """Droplet and particle in a junction

    Droplets are plain, particles chequered, so that one sees them turn; a number is a colour.
    """
    channel = cb.read_cad("geometries/y_junction.step")
    ends = {name: cb.Inflow(mean_velocity=3.0) for name in ("inlet_a", "inlet_b")}
    ends |= {"outlet": cb.Pressure(0.0), "walls": cb.NoSlip()}
    flow = cb.ChannelFlow(cb.StokesProblem(channel, 1.0, ends).solve(accuracy=1e-2).problem)
    drop = cb.Droplet(cb.spline_sphere(0.8, (2.8, 2.4, 2), points=72), cb.SurfaceTension(20.0))
    ball = cb.rigid_sphere(0.6, (2.6, 11.5, 2))
    run = cb.record(cb.Simulation(flow, [drop, ball]).run(2.2, every=0.05))
    frames = [cb.Frame(state.time, state.shapes) for state in run.states]
    cb.draw_movie("junction.gif", channel, frames)
    tracks = {number: run.track(number)[1] for number in (1, 2)}
    cb.draw_trajectories("trajectories.png", channel, tracks)


def plane():
    """Droplets in a plane"""
    drops = [
        cb.Droplet(cb.spline_circle(1.0, place, points=32), cb.capillary_tension(0.2))
        for place in ((-2.5, 0.5), (2.5, -0.5))
    ]
    run = cb.record(cb.Simulation(cb.FreeFlow(cb.shear(dimension=2)), drops).run(9.0, every=0.15))
    frames = [cb.Frame(state.time, state.shapes) for state in run.states]
    cb.draw_movie("plane.gif", None, frames, colour="mean curvature", size=(800, 500))


MAKERS = {
    maker.__name__: maker
    for maker in (
        faces,
        unnamed,
        edges,
        collocation,
        flow,
        pdms,
        luer,
        manifold,
        mixer,
        plane_flow,
        walls,
        paths,
        around,
        droplet,
        velocity,
        passage,
        junction,
        plane,
    )
}


def make(maker) -> None:
    """Run a script where its file names are our pictures' ones."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "geometries").symlink_to(HERE.parent / "geometries")
        with chdir(place):
            maker()
        for made in [*place.glob("*.png"), *place.glob("*.gif")]:
            shutil.copy(made, PICTURES / f"gallery_{made.name}")


def section(maker) -> str:
    """Title, text, pictures and script."""
    title, _, text = inspect.getdoc(maker).partition("\n")
    body = inspect.getsource(maker).split('"""', 2)[2].strip("\n")
    names = re.findall(r'"(\w+\.(?:png|gif))"', body)
    shown = "\n".join(f"![{title.lower()}](pictures/gallery_{name})" for name in names)
    parts = [f"## {title}", text.strip(), f"```python\n{textwrap.dedent(body)}\n```", shown]
    return "\n\n".join(part for part in parts if part)


def main() -> None:
    for name in sys.argv[1:] or MAKERS:
        start = time.perf_counter()
        make(MAKERS[name])
        print(f"{name}: {time.perf_counter() - start:.0f} s", flush=True)
    sections = [section(maker) for maker in MAKERS.values()]
    (HERE / "gallery.md").write_text("\n\n".join([HEAD.strip(), *sections]) + "\n")


if __name__ == "__main__":
    main()
