"""docs/schema describes what result.json holds; it is checked against results of both kinds."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from sherd.locate import locate
from sherd.match import match
from sherd.report.write import write_report
from sherd.results.match_options import MatchOptions
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, whole

SCHEMAS = Path(__file__).parents[2] / "docs" / "schema"


@pytest.fixture(scope="module")
def documents(tmp_path_factory) -> dict[str, dict]:
    folder = tmp_path_factory.mktemp("schema")
    full = creature(5000)
    part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh
    matched = match(full, part, MatchOptions(ignore=(3,))).with_min_confidence(0.5)
    write_report(matched, folder / "match", errors=np.zeros(part.vertex_count))
    write_report(locate(full, part), folder / "locate")
    return {
        kind: json.loads((folder / kind / "result.json").read_text())
        for kind in ("match", "locate")
    }


@pytest.mark.parametrize("kind", ["match", "locate"])
def test_written_documents_obey_their_schema_which_names_every_field(documents, kind) -> None:
    schema, document = json.loads((SCHEMAS / f"{kind}.json").read_text()), documents[kind]
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema)
    assert set(document) == set(schema["properties"])
    for name in ("check", "options", "full"):
        described = schema["properties"][name]
        described = schema["$defs"]["shape"] if "$ref" in described else described
        assert set(document[name]) == set(described["properties"])


@pytest.mark.parametrize(
    ("kind", "path", "value"),
    [
        ("match", ("format",), "sherd match 2"),
        ("match", ("full", "vertices"), -1),
        ("match", ("min_confidence",), 1.5),
        ("locate", ("status",), "well"),
        ("locate", ("files", "part.ply"), "no hash"),
    ],
)
def test_a_wrong_document_is_recognized(documents, kind, path, value) -> None:
    document = copy.deepcopy(documents[kind])
    place = document
    for name in path[:-1]:
        place = place[name]
    place[path[-1]] = value
    schema = json.loads((SCHEMAS / f"{kind}.json").read_text())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, schema)
