"""The user guide's table of ranges: every number of a model file, of the schema itself."""

from __future__ import annotations

from bsm_mesh.model import quantities as q
from bsm_mesh.model.quantity import Quantity
from bsm_mesh.modelfile.keys import numbers_of
from bsm_mesh.modelfile.model_tables import ModelFile
from examples.numbers.pages import Table, markdown

PARTS_OF_KEYS = (  # numbers within keys that hold several of different kinds
    ("slopes a_x, a_y of a stress", q.STRESS_GRADIENT),
    ("in_situ `k0`, its b", q.STRESS_RATIO),
    ("in_situ `surface`; water `table`", q.COORDINATE),
    ("mesh `unit`", q.UNIT_OF_LENGTH),
)


def make_ranges() -> str:
    """Return the table: keys of one kind in one row, each after its table."""
    keys: dict[Quantity, dict[str, list[str]]] = {}
    for table, key, quantity in numbers_of(ModelFile):
        names = keys.setdefault(quantity, {}).setdefault(table, [])
        if key not in names:
            names.append(key)
    rows = [(_named(each), quantity) for quantity, each in keys.items()]
    told = [(name, one.span, _usual(one)) for name, one in (*rows, *PARTS_OF_KEYS)]
    return markdown(("keys", "range", "usual"), told)


def _named(keys: dict[str, list[str]]) -> str:
    return "; ".join(f"{table} {', '.join(f'`{key}`' for key in names)}" for table, names in keys.items())


def _usual(quantity: Quantity) -> str:
    return quantity.usual_span.removesuffix(f" {quantity.unit}")


TABLES = (Table(name="ranges", page="docs/user_guide.md", make=make_ranges, tolerance=0.0),)
