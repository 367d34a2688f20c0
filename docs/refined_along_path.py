"""The Y-junction with small elements where a droplet passes: docs/pictures/refined_along_path.png.

python docs/refined_along_path.py
"""

from pathlib import Path

import numpy as np

import cadbem as cb
from cadbem.space import discontinuous_space

HERE = Path(__file__).parent
PATH = np.array([[2.83, 2.0, 2.0], [6.0, 5.2, 2.0], [8.0, 6.4, 2.0], [13.0, 6.4, 2.0]]).T


def main() -> None:
    channel = cb.read_cad(HERE.parent / "geometries" / "y_junction.step").elevated(2)
    channel = channel.refined(size=0.1, near=PATH, growth=0.3)
    space = discontinuous_space(channel)
    cb.draw_collocation(space, HERE / "pictures" / "refined_along_path.png")


if __name__ == "__main__":
    main()
