"""Run what the pages tell of, and write its numbers into them: ``python -m examples.numbers [NAME ...] [--check]``.

A table of a page is between two marks that have its name. ``--check`` changes nothing, and ends with exit code 1
where a number differs by more than its table allows. ``--quick`` leaves out what takes minutes.
"""

from __future__ import annotations

import sys

from examples.numbers import (
    cassiar,
    dam_abutment,
    dupont,
    earthquakes,
    elasticity,
    flow,
    joint_laws,
    licences,
    ranges,
    rough_joint,
    safety,
    schemes,
    statics,
    thesis,
    threads,
    three_dimensions,
    tunnel,
    tunnel_falls,
    tutorial,
    water_rests,
)
from examples.numbers.command import write_or_check
from examples.numbers.pages import Table

PARTS = (
    tutorial,
    tunnel,
    thesis,
    statics,
    schemes,
    elasticity,
    safety,
    joint_laws,
    rough_joint,
    flow,
    threads,
    licences,
    ranges,
    dam_abutment,
    dupont,
    cassiar,
    three_dimensions,
    tunnel_falls,
    water_rests,
    earthquakes,
)
TABLES: dict[str, Table] = {table.name: table for part in PARTS for table in part.TABLES}


if __name__ == "__main__":
    sys.exit(write_or_check(TABLES.values(), __doc__))
