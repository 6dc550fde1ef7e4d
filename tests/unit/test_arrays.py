"""What a dataclass owns: read-only, with a hash of its content, and the same after a way through another process."""

from __future__ import annotations

import copy
import dataclasses
import multiprocessing
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.arrays import ReadOnlyMapping, content_hash
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.results import Results
from tests.scenes import models, shapes


def everything() -> bsm.Model:
    """Return a model that has one of everything that can be given."""
    blocks = models.framed(bsm.Blocks.from_polygons(shapes.grid(3, 2), rock=["gneiss", "schist"] * 3), 3, 2)
    blocks = dataclasses.replace(blocks, excavations={"one": np.array([5], np.int32)})
    edges = len(blocks.boundaries["top"])
    return bsm.Model(
        title="One of everything",
        blocks=blocks,
        rocks=[bsm.Rock(name, unit_weight=25e3, young=1e9, poisson=0.2) for name in ("gneiss", "schist")],
        joints=[
            bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=2e8, law=bsm.Patton(friction=30)),
            bsm.Joint("J2", filling=bsm.Filling(thickness=0.1, young=1e8, poisson=0.3)),
        ],
        default_joint="J1",
        supports=[bsm.Fixed(boundary="bottom"), bsm.Roller(boundary="left", direction=10)],
        loads=[
            bsm.Pressure(boundary="top", pressure=1e4),
            bsm.EdgeTractions(boundary="top", values=np.ones((edges, 2, 2))),
            bsm.PointLoad(block=1, point=(1.5, 0.5), force=(1, 2)),
        ],
        bolts=[bsm.Bolt(start=(0, 0.4), end=(2.8, 1.7), diameter=0.02, pretension=1e4, name="Bölt")],
        in_situ=bsm.InSitu(surface=2.0, k0=0.5),
        water=bsm.Water(table=[(0, 1.5), (3, 1.0)], joint_pressure={"J1": 1e3}),
        stages=[bsm.Stage(name="dug", excavate=["one", ((2.2, 0.2), (2.8, 0.2), (2.5, 0.9))], water=bsm.Water())],
    )


@pytest.fixture(scope="module")
def results() -> Results:
    return bsm.run(everything(), bsm.Options(scheme="linear"))


def through_pickle(thing: Any) -> Any:
    return pickle.loads(pickle.dumps(thing))


def parts(thing: Any) -> Iterator[Any]:
    """Return a thing and all that it holds."""
    yield thing
    if dataclasses.is_dataclass(thing):
        for field in dataclasses.fields(thing):
            yield from parts(getattr(thing, field.name))
    elif isinstance(thing, tuple):
        for part in thing:
            yield from parts(part)
    elif isinstance(thing, ReadOnlyMapping):
        for part in thing.values():
            yield from parts(part)


def arrays(thing: Any) -> list[np.ndarray]:
    return [part for part in parts(thing) if isinstance(part, np.ndarray)]


@pytest.mark.parametrize("way", [through_pickle, copy.deepcopy, copy.copy])
def test_what_is_given_stays_equal_and_read_only(way: Callable[[Any], Any]) -> None:
    model = everything()
    again = way(model)
    assert again == model
    assert len(arrays(again)) == len(arrays(model)) > 8
    assert not any(array.flags.writeable for array in arrays(again))
    assert way(bsm.Options(tolerance=1e-7)) == bsm.Options(tolerance=1e-7)
    with pytest.raises(TypeError, match="item assignment"):
        again.blocks.boundaries["top"] = np.zeros(1, np.int32)
    np.testing.assert_array_equal(again.blocks.moments.area, model.blocks.moments.area)
    assert bsm.run(again, bsm.Options(scheme="linear")).model_digest == model.digest


@pytest.mark.parametrize("way", [through_pickle, copy.deepcopy, copy.copy])
def test_what_came_out_stays_equal_and_read_only(results: Results, way: Callable[[Any], Any]) -> None:
    again = way(results)
    assert content_hash(again) == content_hash(results)
    assert len(arrays(again)) == len(arrays(results)) > 50
    assert str(again.check()) == str(results.check())
    for made in (results, again):
        assert not any(array.flags.writeable for array in arrays(made))


def test_every_part_of_them_can_be_sent(results: Results) -> None:
    for part in (*parts(everything()), *parts(results)):
        pickle.dumps(part)


@pytest.mark.heavy
def test_to_another_process_and_back(results: Results) -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = pool.apply(bsm.run, (everything(), bsm.Options(scheme="linear")))
    assert there.model_digest == results.model_digest
    np.testing.assert_array_equal(there.stages[-1].displacement, results.stages[-1].displacement)
    assert not any(array.flags.writeable for array in arrays(there))


@pytest.mark.parametrize("kind", [bsm.ModelError, GeometryError])
def test_faults_come_back_one_by_one(kind: type[Any]) -> None:
    error = through_pickle(kind(["one", "two"]))
    assert (type(error), error.faults, str(error)) == (kind, ("one", "two"), str(kind(["one", "two"])))
    assert str(through_pickle(SingularMatrixError("loose"))) == "loose"


def test_a_copy_keeps_what_was_found_out_about_the_outlines() -> None:
    blocks = everything().blocks
    moments = blocks.moments
    assert blocks.with_boundary("more", lambda x, y: y < 1e-9).moments is moments


def test_a_name_that_a_mapping_does_not_have_is_an_error_with_the_names_that_it_has():
    """`KeyError: 'crest'` names neither; for Python it is one all the same."""
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="r")
    blocks = blocks.with_boundary("crests", lambda x, y: y > 0.9)
    with pytest.raises(bsm.ModelError, match=r"^there is no 'crest'; did you mean 'crests'\? \(known: crests\)$"):
        blocks.boundaries["crest"]
    with pytest.raises(KeyError):
        blocks.excavations["core"]
    assert "crest" not in blocks.boundaries
    assert blocks.boundaries.get("crest") is None
    assert blocks.boundaries.get("crest", 3) == 3
