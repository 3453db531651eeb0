"""The same algorithms in NumPy, on one thread: what `experiments -- speed` compares with.

Reads DIR/speed.json and the arrays beside it (64-bit floats, row after row), and prints seconds by work as JSON.
"""
import json
import os
import sys
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np

ROWS = 250  # rows of kernel values at a time: they stay in the cache


def best(repeat, work):
    """Least of a few wall times, and what the work gives."""
    seconds = []
    for _ in range(repeat):
        start = time.perf_counter()
        found = work()
        seconds.append(time.perf_counter() - start)
    return min(seconds), found


def simpson(samples, step):
    """Composite Simpson weights; with an even number of samples the last three intervals use the 3/8 rule."""
    weights = np.zeros(samples)
    end = samples - 4 if samples % 2 == 0 else samples - 1
    for start in range(0, end, 2):
        weights[start : start + 3] += np.array([1.0, 4.0, 1.0]) * step / 3
    if samples % 2 == 0:
        weights[end:] += np.array([1.0, 3.0, 3.0, 1.0]) * 3 * step / 8
    return weights


def gram(x, u, weights, mu):
    """G_ab = sum_kl c_k c_l exp(x_ak . x_bl / mu) (1 + u_ak . u_bl)."""
    count, samples, d = x.shape
    flat_x, flat_u = x.reshape(-1, d), u.reshape(count * samples, -1)
    whole = np.empty((count * samples, count))
    for start in range(0, count * samples, ROWS):
        rows = slice(start, start + ROWS)
        values = flat_x[rows] @ flat_x.T
        values /= mu
        np.exp(values, out=values)
        values *= 1.0 + flat_u[rows] @ flat_u.T
        whole[rows] = values.reshape(-1, count, samples) @ weights
    return np.einsum("k,akb->ab", weights, whole.reshape(count, samples, count))


def fit(x, u, step, order, mu, lam):
    """Weights W of the paper's regression, first or second order."""
    samples = x.shape[1]
    weights = simpson(samples, step)
    right = x[:, -1] - x[:, 0]
    if order == 2:
        duration = step * (samples - 1)
        weights = weights * (duration - step * np.arange(samples))
        right = right - duration * (x[:, 1] - x[:, 0]) / step
    matrix = gram(x, u, weights, mu)
    matrix[np.diag_indices_from(matrix)] += lam
    return np.linalg.solve(matrix, right), weights


def sums(points, weights, at):
    """sum_k w_k exp(-|x - p_k|^2 / 2) for every x."""
    found = np.empty(len(at))
    for i, x in enumerate(at):
        found[i] = np.exp(-0.5 * ((points - x) ** 2).sum(axis=1)) @ weights
    return found


def evaluate(flat, inputs, beta, mu, at):
    """f and g of the folded model at one state after the other."""
    for x in at:
        kernel = np.exp(flat @ x / mu)
        beta.T @ kernel
        beta.T @ (kernel[:, None] * inputs)


def main(folder):
    with open(os.path.join(folder, "speed.json"), encoding="utf-8") as file:
        about = json.load(file)

    def array(name):
        shape = about["arrays"][name]
        return np.fromfile(os.path.join(folder, name + ".f64")).reshape(shape)

    x, u = array("arm_states"), array("arm_inputs")
    seconds = {}
    seconds["fit"], (w, c) = best(2, lambda: fit(x, u, about["arm_step"], 1, about["mu"], about["lambda"]))
    flat, inputs = x.reshape(-1, x.shape[2]), u.reshape(-1, u.shape[2])
    beta = (w[:, None, :] * c[None, :, None]).reshape(len(flat), -1)
    at = array("at")
    few = at[:200]
    whole, _ = best(2, lambda: evaluate(flat, inputs, beta, about["mu"], few))
    seconds["evaluation"] = whole / len(few)
    whole, _ = best(2, lambda: sums(flat, beta[:, 0].copy(), few))
    seconds["kernel_sums"] = whole / (len(few) * len(flat))
    x, u = array("duffing_states"), array("duffing_inputs")
    seconds["duffing"], _ = best(2, lambda: fit(x, u, about["duffing_step"], 2, about["mu"], about["lambda"]))
    print(json.dumps({"numpy": np.__version__, "seconds": seconds}))


main(sys.argv[1])
