"""What the judges do alike: case after case, what was done before not again, and the figures kept."""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parents[1]))  # for blind.py and coverage.py

from blind import git
from coverage import covered as covered
from robots import write_robots
from score import Json

ROOT = Path(__file__).resolve().parents[2]
MODELS = ROOT / "models"


@dataclass(frozen=True)
class Run:
    """folder: of its cases; stamp: seed and commit, with a plus where the checkout has changes."""

    folder: Path
    stamp: Json

    @classmethod
    def of(cls, folder: Path, seed: int) -> "Run":
        changed = git("status", "--porcelain", "workbench", "models", "benchmarks/outside")
        commit = git("rev-parse", "--short", "HEAD") + ("+" if changed else "")
        write_robots(MODELS, folder / "robots")
        return cls(folder, {"seed": seed, "commit": commit})

    def line(self, truth: Json, judged: Callable[[], Json]) -> Json:
        """A case's line; one that fails is kept with its error."""
        line, began = self.stamp | truth, time.process_time()
        try:
            line["found"] = judged()
        except Exception as error:
            line["failed"] = f"{type(error).__name__}: {error}"
        return line | {"cpu_s": round(time.process_time() - began, 2)}

    def lines(self, count: int, done: Callable[[int], Json], truth: Callable[[Json], str]) -> list[Json]:
        """Those of all cases, in FOLDER/results.jsonl as they are done. truth: of a line, in words."""
        path = self.folder / "results.jsonl"
        lines = self._before(path)
        for number in (number for number in range(count) if number not in lines):
            line = lines[number] = done(number)
            with open(path, "a", encoding="utf-8") as file:
                file.write(json.dumps(line, ensure_ascii=False) + "\n")
            answer = line["found"]["headline"] if "found" in line else line["failed"]
            print(f"{number} {line['robot']} {truth(line)}: {answer} ({line['cpu_s']} s)", flush=True)
        return [lines[number] for number in range(count)]

    def _before(self, path: Path) -> dict[int, Json]:
        """The lines of an earlier run, by case."""
        if not path.is_file():
            return {}
        lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        if any({key: line[key] for key in self.stamp} != self.stamp for line in lines):
            raise SystemExit(f"{path} is of another seed or commit: give another folder")
        return {line["case"]: line for line in lines}

    def keep(self, name: str, lines: list[Json], found: Json, drawn: tuple[str, ...] = ()) -> int:
        """Writes `benchmarks/results/NAME`, unless the checkout has changes: figures belong to a commit.
        drawn: what of it pages draw, into `workbench/report/NAME`."""
        failed = {line["case"]: line["failed"].split(":")[0] for line in lines if "failed" in line}
        if self.stamp["commit"].endswith("+"):
            print(f"not written to {name}: the checkout has changes")
        else:
            kept = {"commit": self.stamp["commit"], "seed": self.stamp["seed"], "cases": len(lines)}
            text = json.dumps(kept | {"failed": failed} | found, ensure_ascii=False, indent=1)
            (ROOT / "benchmarks/results" / name).write_text(text + "\n", encoding="utf-8")
            if drawn:
                few = json.dumps(kept | {key: found[key] for key in drawn}, ensure_ascii=False, indent=1)
                (ROOT / "workbench/report" / name).write_text(few + "\n", encoding="utf-8")
        return int(bool(failed))
