"""The trials of an experiment as a table, and its copy without pseudonyms."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

from palpate.base.errors import OutputError
from palpate.experiment.questions import scored
from palpate.experiment.study import Study

Row = dict[str, Any]


def trials(study: Study) -> list[Row]:
    """The trials that count, in the order of the plan: without familiarisation and aborted attempts."""
    rows = []
    for who in study.people:
        ended = study.progress(who).ended
        for one in study.plan[who]:
            if one.repetition and one.number in ended:
                event = ended[one.number]
                facts = {"participant": who, "trial": one.number, "block": one.block, "repetition": one.repetition}
                kinds = {"task": one.task, "condition": one.condition, "attempt": event["attempt"]}
                rows.append({**facts, **kinds, "result": event["result"], **event["measures"]})
    return rows


def answers(study: Study) -> list[Row]:
    """The answers about each condition, one row for each participant and condition."""
    rows = []
    for who in study.people:
        found = study.progress(who).answers
        order = dict.fromkeys(one.condition for one in study.plan[who] if one.block)
        for block, condition in enumerate(order, 1):
            if f"block-{block}" in found:
                rows.append({"participant": who, "condition": condition, **scored(found[f"block-{block}"])})
    return rows


def preferences(study: Study) -> dict[str, int]:
    """How many participants preferred each condition."""
    count = dict.fromkeys(study.experiment.conditions, 0)
    for who in study.people:
        answer = study.progress(who).answers.get("end", {}).get("preference")
        order = list(dict.fromkeys(one.condition for one in study.plan[who] if one.block))
        if answer is not None:
            count[order[int(str(answer).removeprefix("part ")) - 1]] += 1
    return count


def write_shared(study: Study, rows: list[Row], file: Path) -> Path:
    """Write the trials as CSV with random codes instead of pseudonyms, in the order of the codes, without dates.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        codes = study.codes()
        text = io.StringIO()
        if rows:
            writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            shared = [{**row, "participant": codes[row["participant"]]} for row in rows]
            writer.writerows(sorted(shared, key=lambda row: (row["participant"], row["trial"])))
        file.write_text(text.getvalue(), encoding="utf-8")
    except OSError as error:
        why = error.strerror or str(error)
        raise OutputError("the data cannot be written", where=str(file), why=why, mend="name another --out") from None
    return file
