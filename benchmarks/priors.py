"""Which error rate moves with which constant of the diagnosis: python benchmarks/priors.py [DRAWS]

Diagnoses cases of the blind study again with each constant three times larger and smaller (probabilities by
their odds), and prints how many more or fewer errors of each kind there are. Keeps the table in
`benchmarks/results/priors.json`.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

from workbench.studies.blind import case_keys
from workbench.studies.blind.constants import ERRORS, moved

RESULTS = Path(__file__).resolve().parent / "results/priors.json"


def main(draws: int) -> None:
    keys, rows = case_keys(draws), []
    for row in moved(keys, seed=1):
        rows.append(row)
        if not row.constant:
            print(f"{len(keys)} cases; errors: {row.errors}", flush=True)
            continue
        more = {name: row.errors[name] - rows[0].errors[name] for name in ERRORS}
        said = ", ".join(f"{name} {change:+d}" for name, change in more.items() if change) or "nothing moves"
        print(f"{row.constant:<15} {row.value:<8.3g} {said}", flush=True)
    table = {"cases": len(keys), "seed": 1, "rows": [asdict(row) for row in rows]}
    RESULTS.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
