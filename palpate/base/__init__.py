"""What every part needs: arrays, values of scene files, errors, limits, the cache, sweeps, pictures, entry points."""
