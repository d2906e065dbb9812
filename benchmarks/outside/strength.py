"""λ, by how much a fault stands out: its squared error over the noise, without what any calibration takes up.

Noise is the instrument's and that of joints which do not come back to the same angle. Taken up are six
numbers of geometry per joint, the instrument's frame and the places of the targets.
"""

from dataclasses import dataclass, replace

import numpy as np
from arm import Arm, Array, rotation
from statics import Cell, Deflection, points

STEP = 1e-6  # of numerical derivatives, m or rad


@dataclass(frozen=True, eq=False)
class Yardstick:
    """`joints`: (p, 3t, n) points by joint angles; `whiten`: (p, 3t, 3t); `taken`: orthonormal (3pt, k)."""

    joints: Array
    whiten: Array
    taken: Array

    def white(self, shift: Array) -> Array:
        """A shift (p, t, 3) in units of the noise, without the part that a calibration takes up."""
        white = np.einsum("pij,pj->pi", self.whiten, shift.reshape(len(shift), -1)).ravel()
        return white - self.taken @ (self.taken.T @ white)

    def strength(self, shift: Array) -> float:
        """λ of a shift (p, t, 3), in m."""
        white = self.white(shift)
        return float(white @ white)


def yardstick(arm: Arm, cell: Cell, bent: Deflection, sigma: Array, repeatability: Array) -> Yardstick:
    """For an instrument's `sigma` (3,), m, in its own axes and the joints' `repeatability` (n,), rad."""
    joints, whiten, matrix = _columns(arm, cell, bent, sigma, repeatability)
    return Yardstick(joints, whiten, _basis(matrix))


def strength_of_change(
    arm: Arm,
    cells: tuple[Cell, Cell],
    bent: Deflection,
    sigmas: tuple[Array, Array],
    repeatability: Array,
    shift: Array,
) -> float:
    """λ of a shift (p, t, 3), m, in the second of two campaigns, which share the robot's geometry, but
    neither frame nor targets. bent: (second campaign) the arm without the change."""
    still = Deflection.none(len(cells[0].joints), arm.count)
    _, _, first = _columns(arm, cells[0], still, sigmas[0], repeatability)
    _, whiten, second = _columns(arm, cells[1], bent, sigmas[1], repeatability)
    shared = 6 * arm.count
    one = np.pad(first[:, shared:], ((0, len(second)), (0, 0)))
    other = np.pad(second[:, shared:], ((len(first), 0), (0, 0)))
    geometry = np.concatenate([first[:, :shared], second[:, :shared]])
    basis = _basis(np.concatenate([geometry, one, other], 1))
    white = np.einsum("pij,pj->pi", whiten, shift.reshape(len(shift), -1)).ravel()
    taken = basis[len(first) :].T @ white
    return float(white @ white - taken @ taken)


def _columns(
    arm: Arm, cell: Cell, bent: Deflection, sigma: Array, repeatability: Array
) -> tuple[Array, Array, Array]:
    """Points by joint angles (p, 3t, n), what whitens them (p, 3t, 3t), and the whitened columns of what a
    calibration takes up, six of geometry per joint first."""
    start = points(arm, cell, bent)
    poses, targets = start.shape[:2]
    moved = [
        points(arm, cell, replace(bent, joints=bent.joints + STEP * np.eye(arm.count)[joint][None]))
        for joint in range(arm.count)
    ]
    joints = np.stack([(places - start).reshape(poses, -1) / STEP for places in moved], -1)
    covariance = np.einsum("pij,j,pkj->pik", joints, repeatability**2, joints)
    covariance = covariance + np.diag(np.tile(sigma**2, targets))
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    columns = [
        np.einsum("pij,pj->pi", whiten, (points(arm, one, bent) - start).reshape(poses, -1) / STEP).ravel()
        for one in _calibrated(arm, cell)
    ]
    return joints, whiten, np.stack(columns, 1)


def _basis(matrix: Array) -> Array:
    """Orthonormal columns of what a matrix spans."""
    basis, singular, _ = np.linalg.svd(matrix / (np.linalg.norm(matrix, axis=0) + 1e-30), full_matrices=False)
    return basis[:, singular > 1e-7 * singular[0]]


def _calibrated(arm: Arm, cell: Cell) -> list[Cell]:
    """The cell with one number of a calibration after the other moved by a step."""
    moved = []
    for joint in range(arm.count):
        for number in range(6):
            geometry = cell.geometry.copy()
            geometry[joint, number] += STEP
            moved.append(replace(cell, geometry=geometry))
    for direction in STEP * np.eye(3):
        moved.append(replace(cell, instrument_offset=cell.instrument_offset + direction))
        moved.append(replace(cell, instrument_turn=rotation(direction) @ cell.instrument_turn))
    for target in range(len(cell.targets)):
        for number in range(3):
            targets = cell.targets.copy()
            targets[target, number] += STEP
            moved.append(replace(cell, targets=targets))
    return moved
