"""What every room needs: arrays, values of scene files, errors, limits, cache, sweeps, entry points."""
