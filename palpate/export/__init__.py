"""Records as data sets that robot learning and analysis read: LeRobot, Minari, Parquet, CSV, MATLAB, HDF5, Rerun.

export(["runs/a/record.mcap", "runs/b/record.mcap"], "dataset")                # LeRobot v3.0 with Open-H names
export("runs/a/record.mcap", "tables", to="parquet")

A format is a module in `palpate.export.formats`, or an entry point of the group `palpate.exporters`.
"""

from palpate.export.export import export
from palpate.export.options import Options

__all__ = ["Options", "export"]
