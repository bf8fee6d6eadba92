"""Numbers leave with every digit, and as what the format can say."""

import io
import json

import numpy as np

from stickslip.cli.output import document, error_document
from stickslip.results.table import write_csv

TABLE = {
    "value": np.array([0.1 + 0.2, np.nan, -np.inf]),
    "label": np.array([2**64 - 1, 0, 7], dtype=np.uint64),
    "status_name": ["OK", "NEVER_CYCLE", "OK"],
}


def test_a_document_has_the_four_parts():
    parts = json.loads(document("map", {"alpha": 1.2}, TABLE))
    assert parts == {
        "schema": 1,
        "command": "map",
        "parameters": {"alpha": 1.2},
        "result": {
            "value": [0.30000000000000004, None, None],
            "label": [2**64 - 1, 0, 7],
            "status_name": ["OK", "NEVER_CYCLE", "OK"],
        },
    }


def test_an_error_document_names_type_and_reason():
    parts = json.loads(error_document("map", ValueError("alpha = -1")))
    assert parts == {
        "schema": 1,
        "command": "map",
        "error": {"type": "ValueError", "message": "alpha = -1"},
    }


def test_csv_has_a_header_and_reads_back_exactly():
    stream = io.StringIO()
    write_csv(stream, TABLE)
    assert stream.getvalue().splitlines() == [
        "value,label,status_name",
        "0.30000000000000004,18446744073709551615,OK",
        "nan,0,NEVER_CYCLE",
        "-inf,7,OK",
    ]


def test_csv_writes_lists_into_one_cell_and_nothing_for_none():
    stream = io.StringIO()
    write_csv(
        stream, {"points": [[0.1 + 0.2, 1.0], []], "block": [None, 2], "x": [np.float64(1)] * 2}
    )
    assert stream.getvalue().splitlines() == [
        "points,block,x",
        "0.30000000000000004 1.0,,1.0",
        ",2,1.0",
    ]
