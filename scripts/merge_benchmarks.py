"""Merges the Google Benchmark JSON files of one run into one document and prints the table.

usage: merge_benchmarks.py FOLDER [OUTPUT.json]
"""

import json
import os
import pathlib
import sys

COLUMNS = (  # counter, heading, divisor
    ("particle_steps_per_second", "M steps/s", 1e6),
    ("rows_per_second", "M rows/s", 1e6),
    ("bytes_per_second", "GB/s", 1e9),
    ("fraction_of_ceiling", "of ceiling", 1),
    ("steps_per_build", "steps/list", 1),
)


def merge(folder):
    """One document: the context of the first program, the results of all in the order of the programs' names."""
    documents = [json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))]
    if not documents:
        sys.exit(f"merge_benchmarks.py: no result in {folder}: did any benchmark run?")
    results = [result for document in documents for result in document["benchmarks"]]
    return {"context": documents[0]["context"], "benchmarks": results}


def failures(document):
    return [r for r in document["benchmarks"] if r.get("error_occurred")]


def table(document):
    """Lines of text: name, time per iteration, and the counters that a result has."""
    rows = [["benchmark", "time"] + [heading for _, heading, _ in COLUMNS]]
    for result in document["benchmarks"]:
        if result.get("error_occurred"):
            rows.append([result["name"], result["error_message"]] + [""] * len(COLUMNS))
            continue
        counters = [
            f"{result[counter] / divisor:.3g}" if counter in result else "" for counter, _, divisor in COLUMNS
        ]
        rows.append([result["name"], f"{result['real_time']:.4g} {result['time_unit']}"] + counters)
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        yield "  ".join([row[0].ljust(widths[0])] + [c.rjust(w) for c, w in zip(row[1:], widths[1:])]).rstrip()


def main():
    document = merge(pathlib.Path(sys.argv[1]))
    print("contact/ and its peer: " + document["context"]["contact"])
    print("\n".join(table(document)))
    if len(sys.argv) > 2:
        output = pathlib.Path(sys.argv[2])
        beside = output.with_name(output.name + ".part")
        beside.write_text(json.dumps(document, indent=2) + "\n")
        os.replace(beside, output)
    if failures(document):
        sys.exit("merge_benchmarks.py: some benchmarks failed, see the table")


main()
