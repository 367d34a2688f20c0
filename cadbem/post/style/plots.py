"""Plots of numbers: errors against unknowns, profiles against exact solutions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadbem.post.style.style import INK, PALETTE


@dataclass(frozen=True, eq=False)
class Curve:
    """Values ``y`` (N,) over ``x`` (N,), drawn as a ``line``, as marks, or as both.

    Curves with marks get a colour each, others are black; ``colour`` chooses one of the palette.
    ``dashed`` lines are thin, for what is compared with.
    """

    x: ArrayLike
    y: ArrayLike
    label: str = ""
    line: bool = True
    marks: bool = False
    dashed: bool = False
    colour: int | None = None

    def style(self, position: int) -> dict[str, Any]:
        """The style in which matplotlib draws the curve at a ``position`` in the list of curves."""
        chosen = position if self.colour is None and self.marks else self.colour
        return {
            "color": INK if chosen is None else PALETTE[chosen % len(PALETTE)],
            "linestyle": ("--" if self.dashed else "-") if self.line else "none",
            "linewidth": 0.9 if self.dashed else 1.5,
            "marker": "os^Dv"[(chosen or 0) % 5] if self.marks else None,
            "label": self.label or None,
        }


@dataclass(frozen=True, eq=False)
class Plot:
    """Curves on common axes; ``logarithmic`` in both directions, ``decades`` in y alone."""

    x_label: str
    y_label: str
    curves: Sequence[Curve]
    logarithmic: bool = False
    decades: bool = False


def draw_plots(path: str | Path, plots: Sequence[Plot]) -> None:
    """Save plots side by side as a picture whose format is the ending of ``path``."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator

    figure = Figure(figsize=(5.5 * len(plots), 4.2), layout="constrained")
    for axes, plot in zip(np.ravel(figure.subplots(1, len(plots))), plots, strict=True):
        for k, curve in enumerate(plot.curves):
            axes.plot(curve.x, curve.y, **curve.style(k))
        axes.set(xlabel=plot.x_label, ylabel=plot.y_label)
        if plot.decades:
            axes.set(yscale="log")
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
