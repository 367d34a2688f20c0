"""Questions of designers: resistance and flow split of a chip, paths of tracers and droplets."""
