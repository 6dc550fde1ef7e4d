"""Numbers of the examples in which water flows in the joints."""

from __future__ import annotations

import numpy as np

from examples.numbers.pages import Table, markdown
from examples.numbers.runs import run

WEIGHT, LEVEL, BASE = 9810.0, 36.0, 32.0  # of the water; of the reservoir over the base; of the base


def grouted_dam() -> str:
    """Return the table of the dam without, then with curtain and drains."""
    results, rows = run("grouted_dam/model"), []
    straight = WEIGHT * LEVEL * BASE / 2
    blocks = results.blocks
    dam = int(np.flatnonzero(blocks.rock == blocks.rock_names.index("concrete"))[0])
    for stage in results.stages:
        flow = stage.flow
        assert flow is not None
        drained = flow.leaving[flow.places.index("drain 1")] if "drain 1" in flow.places else 0.0
        uplift = stage.water[dam, 1]
        share = f"{uplift / straight:.3f}" if uplift > 0 else "-"
        told = (_minutes(flow.through), _minutes(drained), f"{uplift / 1e6:.2f} MN/m", share)
        rows.append(("model.toml", stage.name, *told, stage.status.value))
    header = (
        "file",
        "stage",
        "seepage",
        "of it to the drains",
        "uplift under the dam",
        "over that of a straight line",
        "verdict",
    )
    return markdown(header, rows)


def drained_slope() -> str:
    """Return the table of the slope with and without drains."""
    rows = []
    for file in ("model", "undrained"):
        for stage in run(f"drained_slope/{file}").stages:
            flow = stage.flow
            assert flow is not None
            leaves = dict(zip(flow.places, flow.leaving.tolist(), strict=True))
            out = [_minutes(leaves.get(name, 0.0)) for name in ("face", "drain 1")]
            moved = f"{1e3 * stage.max_stage_displacement:.2f} mm" if stage.status.is_stable else "more than 5 mm"
            rows.append((f"{file}.toml", stage.name, *out, moved, stage.status.value))
    return markdown(("file", "stage", "out of the face", "out of the drain", "moved in the stage", "verdict"), rows)


def _minutes(discharge: float) -> str:
    """Return a discharge [m2/s] in litres a minute."""
    return f"{6e4 * discharge:.2f} l/min per m" if discharge > 0 else "-"


TABLES: tuple[Table, ...] = (
    Table(name="grouted-dam", page="examples/grouted_dam/README.md", make=grouted_dam, tolerance=0.01),
    Table(name="drained-slope", page="examples/drained_slope/README.md", make=drained_slope, tolerance=0.01),
)
