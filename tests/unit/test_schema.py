"""The command ``schema``: the JSON Schema of model files, of the plane and of three dimensions."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.modelfile.mesh_tables import Table
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.space_tables import SpaceFile
from tests.scenes.small_case import MODEL, Case
from tests.unit.test_cli import SUPPORTED


@pytest.mark.heavy
def test_schema_describes_the_models(case: Case) -> None:
    schema = json.loads(case.run("schema").out)
    jsonschema = pytest.importorskip("jsonschema")
    starter = Path(bsm.__file__).parent / "commands/starters/tunnel/model.toml"
    for text in (MODEL, MODEL + SUPPORTED, starter.read_text()):
        jsonschema.validate(tomllib.loads(text), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tomllib.loads(MODEL.replace("young", "yuong")), schema)
    in_space = json.loads(case.run("schema", "--dimensions", "3").out)
    for name in ("dome", "key_blocks", "roof", "wedge"):
        text = (starter.parents[1] / name / "model.toml").read_text(encoding="utf-8")
        assert text.startswith("#:schema schema.json")
        assert "schema --dimensions 3 >" in text.splitlines()[0]
        jsonschema.validate(tomllib.loads(text), in_space)


@pytest.mark.parametrize(("dimensions", "file"), [("2", ModelFile), ("3", SpaceFile)])
def test_schema_has_every_key(case: Case, dimensions: str, file: type[Table]) -> None:
    schema = json.loads(case.run("schema", "--dimensions", dimensions).out)
    assert set(schema["properties"]) == set(file.model_fields)
    assert schema["additionalProperties"] is False
