"""The page for users of UDEC and RS2: its problem runs, and the keys that it names are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.modelfile.model_tables import ModelFile
from docs.code_blocks import files_of, typed
from tests.scenes.small_case import Case
from tests.scenes.typed_lines import type_line

PAGE = (Path(__file__).parents[2] / "docs/from_udec_and_rs2.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_the_problem_runs(case: Case) -> None:
    files = files_of(PAGE)
    assert set(files) == {"opening.py", "opening.toml"}
    for name, content in files.items():
        case.write(name, content)
    (command,) = typed(PAGE)
    type_line(case, command, "from_udec_and_rs2.md")
    results = bsm.Results.load("out/opening")
    assert [stage.status for stage in results.stages] == ["stable", "stable"]
    assert results.stages[0].max_displacement < 1e-9  # the field balances the loads exactly
    assert -2e-3 < results.histories["crown"].values[-1, 1] < 0  # the crown falls a little
    assert (case.folder / "out/opening/pictures/joints_state.png").is_file()


def test_every_key_that_it_names_is_a_key() -> None:
    schema = ModelFile.model_json_schema()
    known = {key for part in schema["$defs"].values() for key in part.get("properties", {})} | set(schema["properties"])
    tables = PAGE[PAGE.index("## Corresponding terms") : PAGE.index("## Differences")]
    right = " ".join(line.rsplit("|", 2)[1] for line in tables.splitlines() if line.startswith("|"))
    named = set(re.findall(r"`\[+[\w.]+\]+ ([^`]*)`", right))
    keys = {key for text in named for key in re.findall(r"(?:^|, )(\w+)(?= =|,|$)", text)}
    assert len(keys) > 12
    assert keys - {"a_x"} <= known  # the gradient in a list of stresses
