"""The report of key blocks: a page of their own, or a part of the page on a run of the same model."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.folder.key_block_files import NET, PICTURE, RECORD, TABLE, read_key_blocks
from bsm_mesh.folder.result_tables import write_table
from bsm_mesh.pages.report_results import PNG
from bsm_mesh.text.key_block_text import key_block_table, unstable_rows
from tests.scenes.small_case import Case
from tests.unit.test_key_blocks import ROCK, joint, roof
from tests.unit.test_key_blocks_command import ROOF

RUN = ROOF.replace("6]]\n", '6]]\ndefault_joint = "J1"\n') + "".join(
    f'\n[[support]]\nboundary = "{side}"\nfix = "all"\n' for side in ("west", "east", "south", "north")
)
TITLED = '[report]\nproject = "Cavern <7>"\n'


def cells(row: str) -> list[str]:
    """Return the texts in a row of a table."""
    return re.findall(r"<td[^>]*>(.*?)</td>", row)


def first_table(page: str) -> list[list[str]]:
    """Return the rows of the table of blocks below the required factor."""
    table = page[page.index("Blocks below the required factor") :]
    return [found for row in table[: table.index("</table>")].split("<tr>") if (found := cells(row))]


def test_the_page_has_table_pictures_and_input(case: Case) -> None:
    """A pyramid of volume 4 / sqrt(3) falls through a square of 4 m2: its support is its weight over that area."""
    case.write("roof.toml", ROOF + TITLED)
    assert case.run("key-blocks", "roof.toml", "--no-picture").code == 0
    for name in (PICTURE, NET):
        case.write(f"out/roof-key-blocks/{name}", PNG)
    assert case.run("report", "out/roof-key-blocks").code == 0
    page = (case.folder / "out/roof-key-blocks/report.html").read_text(encoding="utf-8")
    ((block, movement, factor, volume, weight, support),) = first_table(page)
    assert (movement, factor) == ("falls", "0.000")
    assert float(volume) == pytest.approx(4 / np.sqrt(3), abs=1e-3)
    assert float(weight.removesuffix(" kN")) == pytest.approx(26 * 4 / np.sqrt(3), abs=0.01)
    assert float(support.removesuffix(" kPa")) == pytest.approx(26 / np.sqrt(3), abs=0.01)
    told = json.loads((case.folder / "out/roof-key-blocks" / RECORD).read_text())
    assert told["falls"] == [int(block)]
    bound = page.count("<td>not removable</td>") + page.count("<td>not judged: reaches a side</td>")
    assert bound == told["at_free_faces"] - 1
    assert page.count('src="data:image/png;base64,') == 2
    assert not re.findall(r'(?:src|href)="(?!data:)', page)
    for words in (
        "Cavern &lt;7&gt;",
        "26 kN/m^3",
        "30 degrees",
        "joint plane J1",
        "Block theory",
        "<summary>Model file<",
    ):
        assert words in page
    for words in ("Verdicts", "Quality of the blocks", "checksums"):
        assert words not in page


@pytest.mark.heavy
def test_the_report_of_a_run_has_the_key_blocks_of_its_model(case: Case) -> None:
    case.write("roof.toml", RUN)
    assert case.run("key-blocks", "roof.toml", "--no-picture").code == 0
    assert case.run("run", "roof.toml").code == 0
    assert case.run("report", "out/roof", "--no-pictures").code == 0
    page = (case.folder / "out/roof/report.html").read_text(encoding="utf-8")
    assert "<h2>Key blocks</h2>" in page
    assert "<h2>Verdicts</h2>" in page
    assert first_table(page)[0][1] == "falls"
    case.write("roof.toml", RUN.replace("friction = 30", "friction = 31"))  # another model
    assert case.run("key-blocks", "roof.toml", "--no-picture").code == 0
    assert case.run("report", "out/roof", "--no-pictures").code == 0
    assert "Key blocks" not in (case.folder / "out/roof/report.html").read_text(encoding="utf-8")


def test_the_table_is_read_as_it_was_written(tmp_path) -> None:
    """Names of joints that a spreadsheet would run, numbers to the last digit, and no number where there is none."""
    found = bsm.key_blocks(roof(), rocks=ROCK, joints=[joint("J1")], excavated=["cavern"], free=["south", "north"])
    none = np.where(np.arange(found.count) % 2, found.support, np.nan)
    table = replace(found, joint_names=("=J,1",), support=none).table()
    write_table(table, tmp_path / TABLE)
    (tmp_path / RECORD).write_text(json.dumps({"at_free_faces": found.count}))
    _, columns = read_key_blocks(tmp_path)
    assert set(columns) == set(table.columns)
    for name, values in table.columns.items():
        assert np.array_equal(columns[name].astype(values.dtype), values, equal_nan=values.dtype.kind == "f"), name
    rows = unstable_rows(columns)
    assert key_block_table(columns, rows) == key_block_table(table.columns, rows)


@pytest.mark.parametrize(("name", "content"), [(TABLE, "block\n1\n"), (TABLE, "a\n1\n"), (RECORD, "{}"), (RECORD, "x")])
def test_damaged_files_are_refused(case: Case, name: str, content: str) -> None:
    case.write("roof.toml", ROOF)
    case.run("key-blocks", "roof.toml", "--no-picture")
    case.write(f"out/roof-key-blocks/{name}", content)
    case.refuses("report", "out/roof-key-blocks", says=["run bsm-mesh key-blocks again"])
