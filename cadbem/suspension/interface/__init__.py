"""One closed interface: its shape in; traction jump, velocity and repair of its points out."""
