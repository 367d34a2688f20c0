"""Inlet pressures by Taylor-Hood elements of NGSolve, which `pip install ngsolve` brings."""

from __future__ import annotations

from typing import Any

import ngsolve as ng
import numpy as np
from netgen.meshing import MeshingParameters
from netgen.occ import OCCGeometry

from benchmarks.peers_cases import Channel, Elements

TERMS = 40  # odd terms of the series of a rectangular duct
QUICK = {"optsteps3d": 1, "optimize3d": "m"}  # of a mesh: one round, of its nodes alone
SHIFT = -1e-4  # of the pressure block, so that a factorisation without pivoting exists
MOST_STEPS, STEP = 20, 1e-8  # that take it back, and the relative change that ends them
Function = Any  # ngsolve has no types


def meshed(channel: Channel, elements: Elements) -> ng.Mesh:
    """Curved tetrahedra; prisms along edges that are cut towards."""
    shape = OCCGeometry(str(channel.file())).shape
    for face in shape.faces:
        face.name = _name(channel, face)
    for edge in shape.edges:
        if any(np.allclose(tuple(edge.center), point, atol=1e-6) for point in channel.edges):
            if elements.near is not None:
                edge.maxh = elements.near
            if elements.levels:
                edge.hpref = 1
    options = MeshingParameters(maxh=elements.size, **({} if elements.care else QUICK))
    mesh = ng.Mesh(OCCGeometry(shape).GenerateMesh(mp=options))
    if elements.levels:
        mesh.RefineHP(levels=elements.levels, factor=elements.factor)
    mesh.Curve(elements.order)
    return mesh


def _name(channel: Channel, face: Any) -> str:
    if channel.openings is None:
        return face.name
    for name, (axis, place) in channel.openings.items():
        if abs(face.center[axis] - place) < 1e-6:
            return name
    return "walls"


def profile(mesh: ng.Mesh, name: str) -> Function:
    """Developed profile of a rectangle or a circle, not scaled, times the normal into the fluid."""
    points = np.array([mesh[v].point for e in mesh.Boundaries(name).Elements() for v in e.vertices])
    region = mesh.Boundaries(name)
    area = ng.Integrate(1, mesh, definedon=region)
    x = ng.CF((ng.x, ng.y, ng.z))
    centre = np.array(ng.Integrate(x, mesh, definedon=region)) / area
    away = points - centre
    radius = np.linalg.norm(away, axis=1).max()
    outward = ng.specialcf.normal(3)
    if abs(np.pi * radius**2 / area - 1) < 1e-3:
        off = x - ng.CF(tuple(centre))
        return -outward * (radius**2 - off * off)
    corner = away[np.argmax(np.linalg.norm(away, axis=1))]
    flat = np.linalg.svd(away, full_matrices=False)[2][:2]
    return -outward * _duct(x, centre, *_sides(flat, corner, away))


def _sides(flat: np.ndarray, corner: np.ndarray, away: np.ndarray) -> tuple[np.ndarray, ...]:
    """Half sides (3,) of a rectangle, the shorter one first."""
    normal = np.cross(*flat)
    corners = away[np.linalg.norm(away, axis=1) > 0.999 * np.linalg.norm(corner)]
    across = np.cross(normal, corner)
    other = corners[np.argmax(corners @ across)]
    halves = [(corner + other) / 2, (corner - other) / 2]
    first, second = sorted(halves, key=lambda half: float(np.linalg.norm(half)))
    return first, second


def _duct(x: Function, centre: np.ndarray, first: np.ndarray, second: np.ndarray) -> Function:
    """The series of a rectangular duct, cosines along its shorter side."""
    a, b = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    off = x - ng.CF(tuple(centre))
    y = off * ng.CF(tuple(first / a))
    depth = ng.sqrt((off * ng.CF(tuple(second / b))) ** 2)
    total = (a * a - y * y) / 2
    for k in range(TERMS):
        rate = (2 * k + 1) * np.pi / (2 * a)
        ratio = ng.exp(rate * (depth - b)) * (1 + ng.exp(-2 * rate * depth))
        ratio /= 1 + float(np.exp(-2 * rate * b))
        total -= 16 * a * a / np.pi**3 * (-1) ** k * ng.cos(rate * y) * ratio / (2 * k + 1) ** 3
    return total


def solved(channel: Channel, elements: Elements) -> tuple[tuple[float, ...], int]:
    """Pressures at the inlets where fluid enters with the mean velocity 1; number of unknowns."""
    mesh = meshed(channel, elements)
    space = _space(mesh, channel, elements.order)
    (u, p), (v, q) = space.TnT()
    form = ng.BilinearForm(space, symmetric=True, condense=True)
    form += (ng.InnerProduct(ng.Grad(u), ng.Grad(v)) - ng.div(u) * q - ng.div(v) * p) * ng.dx
    form += SHIFT * p * q * ng.dx
    form.Assemble()
    flow, entering = ng.GridFunction(space), _entering(mesh, space)
    for given in entering.values():
        flow.vec.data += given.vec
    _solve(form, space, flow)
    pressures = tuple(_pressure(mesh, flow, *item) for item in entering.items())
    return pressures, space.ndof


def _space(mesh: ng.Mesh, channel: Channel, order: int) -> ng.FESpace:
    """No tangential velocity at the outlet, whose normal is an axis."""
    fixed = {f"dirichlet{c}": "outlet" for i, c in enumerate("xyz") if i != channel.outlet}
    velocity = ng.VectorH1(mesh, order=order, dirichlet="inlet.*|walls", **fixed)
    return velocity * ng.H1(mesh, order=order - 1)


def _entering(mesh: ng.Mesh, space: ng.FESpace) -> dict[str, ng.GridFunction]:
    """Flow through each inlet alone, with the mean velocity 1; zero at all other unknowns."""
    fields = {}
    for name in sorted({n for n in mesh.GetBoundaries() if n.startswith("inlet")}):
        region = mesh.Boundaries(name)
        field = ng.GridFunction(space)
        field.components[0].Set(profile(mesh, name), definedon=region)
        rim = space.components[0].GetDofs(mesh.Boundaries("walls"))
        for unknown, on_wall in enumerate(rim):
            if on_wall:
                field.components[0].vec[unknown] = 0.0
        inward = -field.components[0] * ng.specialcf.normal(3)
        order = 3 * space.components[0].globalorder
        mean = ng.Integrate(inward, mesh, definedon=region, order=order)
        mean /= ng.Integrate(1, mesh, definedon=region)
        field.vec.data = (1 / mean) * field.vec
        fields[name] = field
    return fields


def _solve(form: ng.BilinearForm, space: ng.FESpace, flow: ng.GridFunction) -> None:
    """Other unknowns by a factorisation; inner ones of elements are eliminated before.

    The pressure block is SHIFT times its mass instead of zero, so that no pivoting is needed;
    what that changes is taken back step by step.
    """
    inverse = form.mat.Inverse(space.FreeDofs(coupling=True), inverse="sparsecholesky")
    q = space.TestFunction()[1]
    given, before = flow.vec.Copy(), flow.components[0].vec.CreateVector()
    driven = ng.LinearForm(space)
    driven += SHIFT * flow.components[1] * q * ng.dx
    for _ in range(MOST_STEPS):
        before.data = flow.components[0].vec
        driven.Assemble()
        right = driven.vec.Copy()
        right.data += form.harmonic_extension_trans * driven.vec
        right.data -= form.mat * given
        flow.vec.data = given + inverse * right
        flow.vec.data += form.harmonic_extension * flow.vec
        flow.vec.data += form.inner_solve * driven.vec
        before.data -= flow.components[0].vec
        if ng.Norm(before) < STEP * ng.Norm(flow.components[0].vec):
            break


def _pressure(mesh: ng.Mesh, flow: ng.GridFunction, name: str, entering: Function) -> float:
    """Mean pressure, weighted by the profile: the power that enters over the flow.

    That is the plain mean where flow is developed, and far more accurate than the mean of the
    pressure of the elements, which tetrahedra with all corners on walls make wrong.
    """
    velocity, pressure = flow.components
    given = entering.components[0]
    work = ng.InnerProduct(ng.Grad(velocity), ng.Grad(given)) - ng.div(given) * pressure
    power = ng.Integrate(work, mesh, order=2 * velocity.space.globalorder)
    return power / ng.Integrate(1, mesh, definedon=mesh.Boundaries(name))
