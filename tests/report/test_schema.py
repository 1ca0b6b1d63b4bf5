"""docs/schema describes what result.json holds; it is checked against results of both kinds."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from sherd.locate import locate
from sherd.report.write import write_report
from sherd.results.match_options import MatchOptions

SCHEMAS = Path(__file__).parents[2] / "docs" / "schema"


@pytest.fixture(scope="module")
def documents(exhibit_of_size, match_result_of, tmp_path_factory) -> dict[str, dict]:
    folder = tmp_path_factory.mktemp("schema")
    exhibit = exhibit_of_size(region=exhibit_of_size().full.vertices[:, 0] > 0)
    matched = replace(
        match_result_of(exhibit),
        working_vertices={"full": 600, "part": 300},
        timings={"votes": 0.5},
        second_score=0.7,
        options=MatchOptions(ignore=(3,), landmarks=((1, 2),)),
    ).with_min_confidence(0.5)
    write_report(matched, folder / "match", errors=np.zeros(matched.part.vertex_count))
    write_report(locate(matched.full, matched.part), folder / "locate")
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
