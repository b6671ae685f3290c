"""A fleet's drives on an existing engine: what do all of them say together?

fleet.py FOLDER

FOLDER holds the tables that `gripd replay --estimates DRIVE.parquet` wrote, one a drive. Nothing is loaded as a whole:
polars reads of each file the columns it needs, on all cores. Prints, as CSV, how often and with what friction each
source told, and how stiff the tires of the fleet are.
"""

import sys
from pathlib import Path

import polars as pl

drives = pl.scan_parquet(Path(sys.argv[1]) / "*.parquet", include_file_paths="drive")

friction = (
    drives.filter(pl.col("mu_valid") & pl.col("mu_max").is_not_null())
    .group_by("mu_source")
    .agg(
        drives=pl.col("drive").n_unique(),
        samples=pl.len(),
        mu_low=pl.col("mu_max").quantile(0.05),
        mu=pl.col("mu_max").median(),
        mu_high=pl.col("mu_max").quantile(0.95),
    )
    .sort("mu_source")
)

# Each drive's last word on the slope of its driven wheels, and how sure it is.
tires = (
    drives.filter(pl.col("slope_valid"))
    .group_by("drive")
    .agg(
        slope=((pl.col("slope_fl") + pl.col("slope_fr")) / 2).last(),
        std=((pl.col("slope_fl_std") + pl.col("slope_fr_std")) / 2).last(),
        surface_changes=pl.col("surface_changes").max(),
    )
)
over_the_fleet = tires.select(
    drives=pl.len(),
    slope_low=pl.col("slope").quantile(0.05),
    slope=pl.col("slope").median(),
    slope_high=pl.col("slope").quantile(0.95),
    std=pl.col("std").median(),
    surface_changes=pl.col("surface_changes").sum(),
)

rows = drives.select(rows=pl.len(), drives=pl.col("drive").n_unique())
for answer in pl.collect_all([rows, friction, over_the_fleet]):
    print(answer.write_csv(float_precision=3), end="")
