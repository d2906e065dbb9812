"""Draws accounts and holds them against all that is printed, in rounds that come nearer to the print."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from .accounts import Account, Item, Judged, Round, target_of
from .evidence import evidence
from .proposals import Proposal, proposal
from .study_run import StudyRun
from .tasks import run_tasks

CHUNK = 50  # draws per task
ROUNDS = 3


def judge(
    accounts: Sequence[Account],
    items: Sequence[Item],
    draws: int,
    run: StudyRun,
    chunk: int = CHUNK,
    nearer: int | None = None,
) -> Judged:
    """Each account held against all items; resumable, on all cores.

    draws: of each account per round; the first round draws from the priors, the others near the print (an
    account without free values has one round). chunk: draws per task; nearer: draws in the later rounds, as
    many as in the first by default. Raises RuntimeError where an account
    fails, with the end of its traceback.
    """
    found: dict[str, list[Round]] = {account.name: [] for account in accounts}
    for number in range(ROUNDS):
        drawn = [a for a in accounts if a.priors or number == 0]
        towards = {a.name: _nearer(a, items, found[a.name][-1], run.seed) for a in drawn if number > 0}
        count = draws if number == 0 or nearer is None else nearer
        for name, made in _round(drawn, items, towards, count, run, chunk, number).items():
            found[name].append(made)
    first, last = ({name: rounds[at] for name, rounds in found.items()} for at in (0, -1))
    return Judged(accounts, items, first, last, run.seed)


def _nearer(account: Account, items: Sequence[Item], made: Round, seed: int) -> Proposal | None:
    """Where to draw next; None: from the priors again, as nothing that was drawn prints anything."""
    logs = evidence(made.predicted, *target_of(items), made.prior, seed).logs
    return proposal(made.shares, logs) if np.isfinite(logs).any() else None


def _round(
    accounts: Sequence[Account],
    items: Sequence[Item],
    towards: Mapping[str, Proposal | None],
    draws: int,
    run: StudyRun,
    chunk: int,
    number: int,
) -> dict[str, Round]:
    starts = range(0, draws, chunk)
    facts = {
        "seed": run.seed,
        "draws": draws,
        "chunk": chunk,
        "items": {i.name: np.atleast_1d(i.value).tolist() for i in items},
        "priors": {a.name: {k: repr(p) for k, p in a.priors.items()} for a in accounts},
    }
    by_name = {a.name: a for a in accounts}
    done = run_tasks(
        partial(_chunk, by_name, tuple(items), towards, (run.seed, number), chunk, draws),
        [f"{account.name}/{start}" for account in accounts for start in starts],
        run.store(f"accounts_{number + 1}"),
        study=facts,
        workers=run.workers,
        resume=run.resume,
        label=f"accounts, round {number + 1} of {ROUNDS}",
    )
    found = {}
    for account in accounts:
        parts = [done[f"{account.name}/{start}"] for start in starts]
        if failed := next((part for part in parts if part.error), None):
            raise RuntimeError(f"account {account.name}: {failed.error}")
        shares = np.array([row for part in parts for row in part.result["shares"]], dtype=float)
        shares = shares.reshape(draws, len(account.priors))
        rows = np.array([row for part in parts for row in part.result["rows"]], dtype=float)
        to = towards.get(account.name)
        found[account.name] = Round(shares, rows, np.zeros(draws) if to is None else -to.log_density(shares))
    return found


def _chunk(
    accounts: Mapping[str, Account],
    items: Sequence[Item],
    towards: Mapping[str, Proposal | None],
    seed: tuple[int, int],
    chunk: int,
    draws: int,
    key: str,
) -> dict[str, Any]:
    """One task: some draws of one account, with what is not finite as None for JSON."""
    name, _, start = key.rpartition("/")
    account, to = accounts[name], towards.get(name)
    shares, rows = [], []
    for at in range(int(start), min(int(start) + chunk, draws)):
        rng = np.random.default_rng([*seed, zlib.crc32(name.encode()), at])
        share = to.draw(rng) if to else rng.random(len(account.priors))
        free = {key: p.at(float(u)) for (key, p), u in zip(account.priors.items(), share, strict=True)}
        made = account.predict(free, rng)
        row = np.concatenate([np.broadcast_to(i.compared(made[i.name]), i.target[0].shape) for i in items])
        rows.append([float(x) if np.isfinite(x) else None for x in row])
        shares.append([float(u) for u in share])
    return {"shares": shares, "rows": rows}
