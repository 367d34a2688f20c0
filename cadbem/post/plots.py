"""Plots of numbers: errors against unknowns, profiles against exact solutions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cadbem.post.style import INK, PALETTE


@dataclass(frozen=True, eq=False)
class Curve:
    """Values ``y`` (N,) over ``x`` (N,), drawn as a ``line``, as marks, or as both."""

    x: ArrayLike
    y: ArrayLike
    label: str = ""
    line: bool = True
    marks: bool = False


@dataclass(frozen=True, eq=False)
class Plot:
    """Curves on common axes; ``logarithmic`` in both directions."""

    x_label: str
    y_label: str
    curves: Sequence[Curve]
    logarithmic: bool = False


def draw_plots(path: str | Path, plots: Sequence[Plot]) -> None:
    """Save plots side by side as a picture whose format is the ending of ``path``."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator

    figure = Figure(figsize=(5.5 * len(plots), 4.2), layout="constrained")
    for axes, plot in zip(np.ravel(figure.subplots(1, len(plots))), plots, strict=True):
        for k, curve in enumerate(plot.curves):
            axes.plot(
                curve.x,
                curve.y,
                color=PALETTE[k % len(PALETTE)] if curve.marks else INK,
                linestyle="-" if curve.line else "none",
                marker="os^Dv"[k % 5] if curve.marks else None,
                label=curve.label or None,
            )
        axes.set(xlabel=plot.x_label, ylabel=plot.y_label)
        if plot.logarithmic:
            axes.set(xscale="log", yscale="log")
            axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
            axes.xaxis.set_major_formatter("{x:g}")
            axes.xaxis.set_minor_formatter("")
        if any(c.label for c in plot.curves):
            axes.legend(frameon=False)
        axes.grid(alpha=0.3)
    figure.savefig(path, dpi=150)


def fitted_order(counts: ArrayLike, errors: ArrayLike) -> float:
    """Slope of log error against log count by least squares, positive when errors fall."""
    return -float(np.polyfit(np.log(counts), np.log(errors), 1)[0])
